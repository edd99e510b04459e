"""One offline page of the demo's products: pictures from files beside it, texts inside, nothing from elsewhere."""

import html
import re
from collections.abc import Iterable
from itertools import groupby

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; max-width: 74rem; margin: 2rem auto; padding: 0 1rem }
figure { margin: 0 0 2.5rem } figcaption { color: #555; font-size: .9rem; max-width: 70ch }
img { max-width: 100%; height: auto; display: block; margin-bottom: .4rem }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(20rem, 1fr)); gap: 0 1.5rem }
pre { overflow-x: auto; background: #f4f5f7; padding: 1rem; font-size: .8rem }
"""

File = tuple[str, str, str | bytes]
"""A file's name, its caption, and its content."""


def page(files: Iterable[File]) -> str:
    """A page of pictures and texts, with a heading and a caption for each file.

    Examples
    --------
    >>> text = page([("a<b.txt", "one & two", "1 < 2")])
    >>> "<h2>a&lt;b.txt</h2>" in text, "<pre>1 &lt; 2</pre>" in text, "http" in text
    (True, True, False)
    """
    groups = [list(group) for _, group in groupby(files, key=lambda file: _figure(file[0]))]
    body = "\n".join(_group(group) for group in groups)
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>symrt demo</title>
<meta name="viewport" content="width=device-width"><style>{STYLE}</style></head>
<body><h1>Rendered once, then asked</h1>
{body}
</body></html>
"""


def _figure(name: str) -> str:
    """The figure that a file is a part of: figure-3, for figure-3a.png and figure-3b.png."""
    found = re.match(r"figure-\d+", name)
    return found[0] if found else name


def _group(files: list[File]) -> str:
    parts = "\n".join(_part(*file) for file in files)
    return f'<div class="pair">\n{parts}\n</div>' if len(files) > 1 else parts


def _part(name: str, caption: str, content: str | bytes) -> str:
    title, text = html.escape(name), html.escape(caption)
    if isinstance(content, str):
        return f"<h2>{title}</h2><p>{text}</p><pre>{html.escape(content)}</pre>"
    image = f'<img src="{title}" alt="{title}">'
    return f"<figure><h2>{title}</h2>{image}<figcaption>{text}</figcaption></figure>"
