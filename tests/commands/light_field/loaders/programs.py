"""The programs by the names of their checkouts."""
import importlib


def by_module(module, version=None):
    def loader():
        made = importlib.import_module(module)
        if version:
            made.version = version
        return made

    return loader


PROGRAMS = {
    "gaussian-splatting": by_module("inria_readers"),
    "gsplat-1.5.3": by_module("gsplat_examples", "gsplat-1.5.3"),
    "gsplat": by_module("gsplat_examples", "gsplat"),
    "nerfstudio": by_module("nerfstudio_parsers"),
    "3dgrut": by_module("threedgrut_datasets"),
}
