"""What loaders of other programs give of `ulf export`:

    python3 loaders_of_others.py LOADERS EXPORTS

LOADERS holds checkouts as loaders/checkouts.txt names them; those that are missing are left out. EXPORTS holds
exports, each with the truth beside it as EXPORT.json: its form, what its views show where, its points. Prints a line
"PROGRAM EXPORT: verdict" for each. Needs Debian's python3-torch, python3-torchvision, python3-opencv, python3-scipy,
python3-pil, python3-tqdm, python3-rich, python3-open3d.
"""
import json
import os
import subprocess
import sys

sys.dont_write_bytecode = True
here = os.path.join(os.path.dirname(os.path.abspath(__file__)), "loaders")
sys.path.insert(0, here)
from programs import PROGRAMS


def verdict(row):
    if "error" in row:
        return "no (" + " ".join(row["error"].split())[:70] + ")"
    said = []
    if row["images"] != row["of"] or row["photographs"] != row["of"]:
        said.append(f"{row['photographs']} of {row['of']} photographs")
    said.append("right" if row["px"] < 1e-3 else f"off by {row['px']:.2g} px")
    if row["masks"]:
        said.append("masks" if row["masks"] == row["of"] else f"{row['masks']} of {row['of']} masks")
    if row["points"]:
        elsewhere = row["points_off"] is not None and row["points_off"] > 1e-5
        said.append("points elsewhere" if elsewhere else "points")
    return ", ".join(said)


def main():
    loaders, folder = map(os.path.abspath, sys.argv[1:])
    exports = sorted(os.path.join(folder, name[:-5]) for name in os.listdir(folder) if name.endswith(".json"))
    failed = False
    for program in PROGRAMS:
        if not os.path.isdir(os.path.join(loaders, program)):
            continue
        run = subprocess.run([sys.executable, os.path.join(here, "one.py"), program, loaders, *exports],
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for line in run.stdout.splitlines():
            row = json.loads(line)
            print(f"{program} {row['export']}: {verdict(row)}", flush=True)
        if run.returncode:
            failed = True
            print(run.stderr[-3000:], file=sys.stderr)
    return failed


sys.exit(main())
