"""Build the site into `site/`: nothing is fetched, and a warning is an error.

    python docs/build.py            # with the figures as `rotor-ida reproduce` makes them
    python docs/build.py --quick    # with coarse ones

Results that are up to date are not computed again.
"""

import argparse
import re
import sys
from pathlib import Path

HERE = Path(__file__).parent
# What a browser fetches by itself, from another host.
FETCHED = re.compile(
    r"<(?:script|img|iframe|source)[^>]*\bsrc=[\"'](?:https?:)?//[^\"']*"
    r"|<link[^>]*\bhref=[\"'](?:https?:)?//[^\"']*|@import[^;]*//[^;]*|url\([\"']?(?:https?:)?//[^)]*"
)
LINKED = re.compile(r"<a [^>]*\bhref=\"(https?://[^\"#]*)")


def fetched_from_elsewhere(site):
    """Return what pages and style sheets would load from another host."""
    pages = [path for kind in ("*.html", "*.css") for path in site.rglob(kind)]
    return [
        f"{path.relative_to(site)}: {found}"
        for path in sorted(pages)
        for found in FETCHED.findall(path.read_text(encoding="utf-8"))
    ]


def linked_elsewhere(site):
    """Return the addresses of other hosts to which pages link."""
    texts = (path.read_text(encoding="utf-8") for path in site.rglob("*.html"))
    return sorted({found for text in texts for found in LINKED.findall(text)})


def missing():
    """Return in one line what keeps the site from being built, or an empty text."""
    try:
        from rotor_ida.core.library import build_info  # noqa: PLC0415 - any of these may be missing

        build_info()
        import sphinx_design  # noqa: F401, PLC0415
    except ImportError as error:  # an InstallationError is one
        cure = "" if "run: " in str(error) else "; run: pip install -e '.[docs]'"
        return f"the site cannot be built: {error}{cure}"
    return ""


def main():
    """Build the site, check that it loads nothing from elsewhere, and print its size."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="coarse figures")
    parser.add_argument("--out", type=Path, default=HERE.parent / "site", help="where to")
    parser.add_argument("--links", action="store_true", help="list all links to other hosts")
    given = parser.parse_args()
    if reason := missing():
        print(reason, file=sys.stderr)
        return 1
    from sphinx.cmd.build import main as sphinx_build  # noqa: PLC0415 - once it is known to be there

    tags = ["-t", "quick"] if given.quick else []
    strictly = ["-q", "-W", "--keep-going", "-n", *tags, "-d", str(HERE / ".doctrees")]
    status = sphinx_build([*strictly, str(HERE), str(given.out)])
    if status == 0:
        loaded = fetched_from_elsewhere(given.out)
        if loaded:
            print("\n".join(["loaded from another host:", *loaded]), file=sys.stderr)
            return 1
        if given.links:
            print("\n".join(linked_elsewhere(given.out)))
        size = sum(path.stat().st_size for path in given.out.rglob("*") if path.is_file())
        print(f"{given.out / 'index.html'}: {size / 1e6:.0f} MB")
    return status


if __name__ == "__main__":
    sys.exit(main())
