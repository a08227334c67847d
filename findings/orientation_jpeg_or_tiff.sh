#!/usr/bin/env bash
# Version:  FFmpeg 5.1, Pillow 9.4 (Debian 12).
# Expected: a program turns by the orientation mark of a picture always or never, whatever the kind of file; a call that says
#           that it turns a picture by its mark turns it once.
# Seen:     FFmpeg turns a JPEG (its Exif) and leaves a TIFF with the same mark. Pillow does the opposite by itself: a TIFF
#           is turned while it is loaded, a JPEG is not. The mark stays at 6, so that ImageOps.exif_transpose turns the JPEG
#           rightly and the TIFF a second time: it comes out upside down, in the size of the raw picture.
# Matters:  a set of JPEGs that was turned rightly is no test for the same set in TIFF; sizes in poses and pictures part.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
[ -x /usr/bin/python3 ] || exit 77
mkdir -p debs/partial
apt-get -qq -y -d -o Dir::Cache::archives="$work/debs/" install --reinstall --no-install-recommends \
  'ffmpeg=7:5.1*' 'libavcodec59=7:5.1*' 'libavformat59=7:5.1*' 'python3-pil=9.4.0*' >/dev/null 2>&1 || exit 77
for package in debs/*.deb; do dpkg-deb -x "$package" root; done
export LD_LIBRARY_PATH=$work/root/usr/lib/x86_64-linux-gnu
export PYTHONPATH=$work/root/usr/lib/python3/dist-packages

# One picture of 96x64, red in its first corner and black elsewhere; its mark says: turn clockwise (6). Shown rightly the red
# is in the upper right corner.
/usr/bin/python3 - <<'PY' || exit 77
import struct
from PIL import Image
picture = Image.new('RGB', (96, 64))
picture.paste((255, 0, 0), (0, 0, 24, 24))
mark = Image.Exif()
mark[274] = 6
picture.save('p.jpg', quality=95, exif=mark)
data = picture.tobytes()
values = [(256, 3, 96), (257, 3, 64), (258, 3, 0), (259, 3, 1), (262, 3, 2), (273, 4, 14), (274, 3, 6),
          (277, 3, 3), (278, 3, 64), (279, 4, len(data))]
entries = b''.join(struct.pack('<HHII', t, k, 3 if t == 258 else 1, 8 if t == 258 else v) for t, k, v in values)
head = struct.pack('<2sHI3H', b'II', 42, 14 + len(data), 8, 8, 8)
open('p.tif', 'wb').write(head + data + struct.pack('<H', len(values)) + entries + bytes(4))
PY
cat >corner.py <<'PY'
import sys
from PIL import Image, ImageOps
def corner(picture):
    w, h = picture.size
    at = {'upper left': (4, 4), 'upper right': (w - 5, 4), 'lower left': (4, h - 5), 'lower right': (w - 5, h - 5)}
    return ''.join(name for name, place in at.items() if picture.convert('RGB').getpixel(place)[0] > 200) + ' %dx%d' % (w, h)
for file in 'p.jpg', 'p.tif':
    by_ffmpeg = corner(Image.open(file + '.png'))
    loaded = Image.open(file)
    loaded.load()
    turned = ImageOps.exif_transpose(Image.open(file))
    print('%s: FFmpeg %s, Pillow %s, exif_transpose %s' % (file, by_ffmpeg, corner(loaded), corner(turned)))
PY
for file in p.jpg p.tif; do root/usr/bin/ffmpeg -v error -i $file $file.png || exit 77; done
seen=$(/usr/bin/python3 corner.py) || exit 1
echo "$seen" | sed 's/^/   red in: /'
[ "$seen" = "p.jpg: FFmpeg upper right 64x96, Pillow upper left 96x64, exif_transpose upper right 64x96
p.tif: FFmpeg upper left 96x64, Pillow upper right 64x96, exif_transpose lower right 96x64" ]
