"""compare_captures.py A B: every eighth photograph that both light fields hold, rendered from the others of each."""
import hashlib
import sys

import numpy as np
import ulf

fields = [ulf.open(folder) for folder in sys.argv[1:3]]
ids = [{hashlib.sha256(view.path.read_bytes()).digest(): view.id for view in field.views} for field in fields]
shared = sorted(ids[0].keys() & ids[1].keys(), key=ids[0].get)[::8]
scores = []
for field, of in zip(fields, ids):
    pictures = {picture.id: picture for picture in field.left_out([of[photograph] for photograph in shared])}
    errors = []
    for picture in (pictures[of[photograph]] for photograph in shared):
        difference = picture.rendered.astype(float) - picture.photograph
        errors.append(np.mean(difference[picture.valid] ** 2))
    scores.append(10 * np.log10(255**2 / np.array(errors)))
for photograph, psnr_a, psnr_b in zip(shared, *scores):
    print(f"view {ids[0][photograph]}: {psnr_a:.2f} dB and {psnr_b:.2f} dB")
print(f"mean: {scores[0].mean():.2f} dB and {scores[1].mean():.2f} dB over {len(shared)} photographs")
