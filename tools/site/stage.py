"""Copies the pages, and the files that they link to, into the folder of an mdBook: stage.py FOLDER.

The order of the pages is that of the table in docs/README.md. Links stay as they are, because the copy has the folders of the
repository.
"""

import re
import shutil
import sys
from pathlib import Path

INDEX = Path("docs/README.md")
LINK = re.compile(r"\]\(([^)#\s]+)[^)]*\)")
CLIENTS = ["api/python/README.md", "api/typescript/README.md", "api/cpp/README.md", "api/deploy/README.md"]
REFERENCES = """# References

- [Every route and field of the HTTP interface](http/index.html)
- The crates: [core](rust/revprio_core/index.html), [robot](rust/revprio_robot/index.html), [client](rust/revprio_api/index.html),
  [laboratory](rust/revprio_lab/index.html), [program](rust/revprio/index.html)
"""
BOOK = """[book]
title = "revprio"
language = "en"

[output.html]
default-theme = "light"
preferred-dark-theme = "navy"
no-section-label = true

[output.html.search]
limit-results = 20
"""


def linked(page: Path) -> set[Path]:
    """Returns the files of the repository that a page links to."""
    targets = (match[1] for match in LINK.finditer(page.read_text(encoding="utf-8")))
    paths = ((page.parent / target).resolve() for target in targets if "://" not in target)
    return {path.relative_to(Path.cwd()) for path in paths if path.is_file()}


def title(page: Path) -> str:
    """Returns the first heading of a page."""
    return next(line[2:].strip() for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("# "))


def summary(pages: list[Path]) -> str:
    """Returns the contents of the book: the guides, then the other pages, in the order of the index."""
    guides = [page for page in pages if page.parent.name == "guides"]
    others = sorted((page for page in pages if page not in guides), key=lambda page: page.name == "glossary.md")
    lines = ["# Contents", "", "[revprio](README.md)"]
    for heading, part in [("Guides", guides), ("Pages", others), ("Clients and operation", map(Path, CLIENTS))]:
        lines += ["", f"# {heading}", "", *(f"- [{title(page)}]({page})" for page in part)]
    return "\n".join([*lines, "", "[References](references.md)", "[Changelog](CHANGELOG.md)", ""])


def main() -> None:
    """Writes the folder."""
    book = Path(sys.argv[1])
    pages = [path for match in LINK.finditer(INDEX.read_text(encoding="utf-8"))
             if "://" not in match[1] and (path := INDEX.parent / match[1]).suffix == ".md" and ".." not in match[1]]
    pages = list(dict.fromkeys(pages))
    files = {Path("README.md"), Path("CHANGELOG.md"), INDEX, *pages, *map(Path, CLIENTS)}
    new = files
    while new := {file for page in new if page.suffix == ".md" for file in linked(page)} - files:
        files |= new
    for file in files:
        copy = book / "src" / file
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, copy)
    (book / "src/references.md").write_text(REFERENCES, encoding="utf-8")
    (book / "src/SUMMARY.md").write_text(summary(pages), encoding="utf-8")
    (book / "book.toml").write_text(BOOK, encoding="utf-8")


main()
