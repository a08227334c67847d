"""What a program's loader gives of exports: one.py PROGRAM LOADERS EXPORT... prints a JSON line for each."""
import json
import os
import sys
import traceback

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import given
from programs import PROGRAMS

name, root, *exports = sys.argv[1:]
out = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)  # what loaders print
loader = PROGRAMS[name]()
loader.prepare(root)
for export in exports:
    truth = json.load(open(export + ".json"))
    if truth["form"] not in loader.FORMS:
        continue
    row = {"program": name, "export": os.path.basename(export)}
    try:
        row.update(given.compare(loader.load(export, truth["form"]), truth))
    except (Exception, SystemExit) as error:
        if os.environ.get("ULF_LOADERS_TRACE"):
            traceback.print_exc()
        row["error"] = f"{type(error).__name__}: {error}".strip()
    print(json.dumps(row), file=out, flush=True)
