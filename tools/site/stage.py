"""Copies the pages, and the files that they link to, into the folder of an mdBook: stage.py FOLDER.

The order of the pages is that of the table in docs/README.md. The copy has the folders of the repository, so relative links stay
as they are. A link to a crate becomes a link to its documentation; a link to another folder becomes plain text.
"""

import os
import re
import shutil
import sys
from pathlib import Path

INDEX = Path("docs/README.md")
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)#\s]*)(#[^)\s]*)?\)")
CLIENTS = ["api/python/README.md", "api/typescript/README.md", "api/cpp/README.md", "api/deploy/README.md"]
FIGURE = ("docs/methods.md", "(methods.svg)", '\n\n<div class="live-figure" data-figure="conflict"></div>')
"""A page, the picture below which its live figure stands, and the place of the figure."""

REFERENCES = """# References

- [Every route and field of the HTTP interface](http/index.html)
- The crates: [core](rust/revprio_core/index.html), [robot](rust/revprio_robot/index.html), [client](rust/revprio_api/index.html),
  [laboratory](rust/revprio_lab/index.html), [program](rust/revprio/index.html)
"""
BOOK = """[book]
title = "revprio"
language = "en"

[build]
# The preprocessors would rename README.md and read `{{` in texts.
use-default-preprocessors = false

[output.html]
default-theme = "light"
preferred-dark-theme = "navy"
no-section-label = true
additional-css = ["live.css"]
additional-js = ["live-data.js", "live.js"]

[output.html.search]
limit-results = 20
"""


def pages_linked_in(page: Path) -> list[Path]:
    """Returns the pages of the repository that a page links to, in order."""
    return [path for path in linked(page) if path.suffix == ".md" and path.is_file()]


def linked(page: Path) -> list[Path]:
    """Returns the files and folders of the repository that a page links to."""
    targets = [match[3] for match in LINK.finditer(page.read_text(encoding="utf-8"))]
    paths = [(page.parent / target).resolve() for target in targets if target and "://" not in target]
    return [path.relative_to(Path.cwd()) for path in paths]


def title(page: Path) -> str:
    """Returns the first heading of a page."""
    return next(line[2:].strip() for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("# "))


def all_pages() -> dict[str, list[Path]]:
    """Returns the pages by the parts of the book."""
    index = list(dict.fromkeys(page for page in pages_linked_in(INDEX) if page.parts[0] == "docs"))
    guides = [page for page in index if page.parent.name == "guides"]
    others = sorted((page for page in index if page not in guides), key=lambda page: page.name == "glossary.md")
    parts = {"Guides": guides, "Pages": others, "Clients and operation": [Path(page) for page in CLIENTS]}
    known = {Path("README.md"), Path("CHANGELOG.md"), INDEX, *sum(parts.values(), [])}
    more: list[Path] = []
    queue = sorted(known)
    while queue:
        page = queue.pop(0)
        new = [path for path in pages_linked_in(page) if path not in known]
        known.update(new)
        more += new
        queue += new
    return parts | {"More": more}


def summary(parts: dict[str, list[Path]]) -> str:
    """Returns the contents of the book."""
    lines = ["# Contents", "", "[revprio](README.md)", f"[{title(INDEX)}]({INDEX})"]
    for heading, pages in parts.items():
        if pages:
            lines += ["", f"# {heading}", "", *(f"- [{title(page)}]({page})" for page in pages)]
    return "\n".join([*lines, "", "---", "", "[References](references.md)", "[Changelog](CHANGELOG.md)", ""])


def staged(page: Path) -> str:
    """Returns the text of a page, without links to folders."""

    def replaced(match: re.Match[str]) -> str:
        target = match[3]
        path = (page.parent / target).resolve()
        if not target or "://" in target or not path.is_dir():
            return match[0]
        path = path.relative_to(Path.cwd())
        if path.parent != Path("crates"):
            return match[2]
        crate = os.path.relpath(f"rust/revprio_{path.name}/index.html", page.parent)
        return f"[{match[2]}]({crate})"

    text = LINK.sub(replaced, page.read_text(encoding="utf-8"))
    name, picture, figure = FIGURE
    if page == Path(name):
        if text.count(picture) != 1:
            sys.exit(f"{name} does not have the picture {picture}, below which the live figure stands")
        text = text.replace(picture, picture + figure)
    return text


def main() -> None:
    """Writes the folder."""
    book = Path(sys.argv[1])
    parts = all_pages()
    pages = [Path("README.md"), Path("CHANGELOG.md"), INDEX, *sum(parts.values(), [])]
    for page in pages:
        copy = book / "src" / page
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_text(staged(page), encoding="utf-8")
        for path in linked(page):
            if not path.exists():
                sys.exit(f"{page}: there is no {path}")
            if path.is_file() and path.suffix != ".md":
                (book / "src" / path).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, book / "src" / path)
    (book / "src/references.md").write_text(REFERENCES, encoding="utf-8")
    (book / "src/SUMMARY.md").write_text(summary(parts), encoding="utf-8")
    (book / "book.toml").write_text(BOOK, encoding="utf-8")
    print(f"{len(pages)} pages")


main()
