"""Hooks of mkdocs: they add pages from the repository's root, and change links for the site."""
from __future__ import annotations

import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
ROOT_PAGES = ('CHANGELOG.md', 'CONTRIBUTING.md')
ASSETS = ('iframe-worker.js', 'site.css')
_FOREIGN = re.compile(r'<(?:script|img|iframe|source)\b[^>]*\bsrc="(?:https?:)?//[^"]*"'
                      r'|<link\b[^>]*\bhref="(?:https?:)?//[^"]*"')
_LINK = re.compile(r'(?<=\]\()[^)#\s:]+(?=[)#])')


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the pages of the root, and the files that pages need."""
    for name in ROOT_PAGES:
        files.append(File.generated(config, name, content=(ROOT / name).read_text('utf-8')))
    for name in ASSETS:
        files.append(File.generated(config, f'assets/{name}',
                                    content=(HERE / name).read_text('utf-8')))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Converts a page from GitHub's Markdown to Python-Markdown."""
    on_site = page.file.src_uri
    in_repository = on_site if on_site in ROOT_PAGES else f'docs/{on_site}'

    def link(match: re.Match[str]) -> str:
        target = posixpath.normpath(posixpath.join(posixpath.dirname(in_repository), match[0]))
        target = target[len('docs/'):] if target.startswith('docs/') else target
        return posixpath.relpath(target, posixpath.dirname(on_site) or '.')
    return _LINK.sub(link, plain_pipes(markdown))


def plain_pipes(markdown: str) -> str:
    r"""Replaces `a\|b` in tables: GitHub needs the backslash, but Python-Markdown shows it."""
    return re.sub(r'`[^`\n]*`', lambda code: code[0].replace(r'\|', '|'), markdown)


def on_post_page(output: str, page: Page, config: MkDocsConfig) -> str:
    """Raises PluginError if a page loads something from the internet."""
    foreign = _FOREIGN.search(output)
    if foreign:
        raise PluginError(f'{page.file.src_uri} loads {foreign[0]}: the site must work without a '
                          'network, so put it beside the other files of scripts/docs_site')
    return output
