"""python3 colmap_keypoints.py DATABASE: the features of COLMAP's database, as one JSON object: [x, y] by photograph."""
import json
import sqlite3
import struct
import sys

database = sqlite3.connect(sys.argv[1])
features = {}
for name, rows, columns, data in database.execute(
        "SELECT name, rows, cols, data FROM images JOIN keypoints USING (image_id)"):
    numbers = struct.unpack(f"<{rows * columns}f", data or b"")
    features[name] = [numbers[i:i + 2] for i in range(0, len(numbers), columns)]
print(json.dumps(features))
