"""Checks a built site: check.py FOLDER.

Every relative link must lead to a file, and its fragment to an element of that page. The index of the search must contain every
page. The pages of rustdoc check their own links.
"""

import sys
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

GENERATED = {"404.html", "print.html", "toc.html", "index.html"}
"""Pages without an entry in the search: they repeat others."""


class Links(HTMLParser):
    """Collects the targets of links and pictures, and the names of elements."""

    def __init__(self) -> None:
        """Starts without links."""
        super().__init__()
        self.targets: list[str] = []
        self.names: set[str] = set()

    def handle_starttag(self, _: str, attributes: list[tuple[str, str | None]]) -> None:
        """Collects the target and the name of an element."""
        self.targets += [value for name, value in attributes if name in ("href", "src") and value]
        self.names |= {value for name, value in attributes if name in ("id", "name") and value}


@cache
def read(page: Path) -> Links:
    """Reads a page."""
    links = Links()
    links.feed(page.read_text(encoding="utf-8"))
    return links


def is_broken(site: Path, page: Path, target: str) -> bool:
    """Returns whether a target does not exist."""
    parts = urlsplit(target)
    if parts.scheme or parts.netloc or (not parts.path and not parts.fragment):
        return False
    path = site / unquote(parts.path).lstrip("/") if parts.path.startswith("/") else page.parent / unquote(parts.path)
    goal = (path if parts.path else page).resolve()
    if not goal.is_file():
        return True
    is_own = goal.suffix == ".html" and goal.relative_to(site).parts[0] not in ("rust", "http")
    return is_own and bool(parts.fragment) and unquote(parts.fragment) not in read(goal).names


def main() -> None:
    """Ends with status 1 if something is wrong."""
    site = Path(sys.argv[1]).resolve()
    pages = [page for page in site.rglob("*.html") if page.relative_to(site).parts[0] not in ("rust", "http")]
    checked = [page for page in pages if page.name not in ("404.html", "print.html", "toc.html")]
    wrong = [f"{page.relative_to(site)}: {target} leads nowhere"
             for page in checked for target in dict.fromkeys(read(page).targets) if is_broken(site, page, target)]
    index = "".join(path.read_text(encoding="utf-8") for path in site.glob("searchindex*.js"))
    names = [str(page.relative_to(site)) for page in pages if str(page.relative_to(site)) not in GENERATED]
    wrong += [f"{name} is not in the search" for name in names if name not in index]
    print(f"{len(pages)} pages, {len(wrong)} errors", *wrong, sep="\n")
    sys.exit(bool(wrong) or len(pages) < 10)


main()
