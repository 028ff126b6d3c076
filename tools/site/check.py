"""Checks that every relative link of the pages of a site leads to a file: check.py FOLDER."""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Links(HTMLParser):
    """Collects the targets of links and pictures."""

    def __init__(self) -> None:
        """Starts without links."""
        super().__init__()
        self.targets: list[str] = []

    def handle_starttag(self, _: str, attributes: list[tuple[str, str | None]]) -> None:
        """Collects the target of an element."""
        self.targets += [value for name, value in attributes if name in ("href", "src") and value]


def broken(site: Path, page: Path) -> list[str]:
    """Returns the targets of a page that do not exist."""
    links = Links()
    links.feed(page.read_text(encoding="utf-8"))
    paths = {urlsplit(target).path for target in links.targets if not urlsplit(target).scheme}
    exists = lambda path: (page.parent / unquote(path)).exists() or (site / unquote(path).lstrip("/")).exists()  # noqa: E731
    return [path for path in paths if path and not exists(path)]


def main() -> None:
    """Ends with status 1 if a link is broken. The pages of rustdoc check their own links."""
    site = Path(sys.argv[1])
    pages = [page for page in site.rglob("*.html") if page.relative_to(site).parts[0] != "rust"]
    wrong = [f"{page.relative_to(site)}: {path}" for page in pages for path in broken(site, page)]
    print(f"{len(pages)} pages, {len(wrong)} broken links", *wrong, sep="\n")
    sys.exit(bool(wrong))


main()
