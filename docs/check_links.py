"""Every link of the built site leads to a file of it, and nothing is loaded from the network."""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Links(HTMLParser):
    def __init__(self):
        super().__init__()
        self.loaded, self.linked = [], []

    def handle_starttag(self, tag, attributes):
        of = dict(attributes)
        if of.get("src"):
            self.loaded.append(of["src"])
        if of.get("href"):
            (self.loaded if tag == "link" else self.linked).append(of["href"])


def problems(site, page):
    links = Links()
    links.feed(page.read_text(encoding="utf-8"))
    for target in links.loaded + links.linked:
        parts = urlsplit(target)
        if parts.scheme or parts.netloc:
            if target in links.loaded and parts.scheme != "data":
                yield f"loads {target}"
        elif parts.path and not (page.parent / unquote(parts.path)).exists():
            yield f"links to {target}, which is not there"


site = Path(sys.argv[1])
# The documentation of the crates is checked by the tool that writes it.
pages = [page for page in sorted(site.rglob("*.html")) if "rust" not in page.parts]
found = [f"{page}: {problem}" for page in pages for problem in problems(site, page)]
print("\n".join(found) or f"{len(pages)} pages, no broken link")
sys.exit(bool(found) or not pages)
