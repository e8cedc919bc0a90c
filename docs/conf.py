"""The site: `make docs` builds it, with every warning an error."""

import os
import re
import subprocess
import sys
from pathlib import Path

import stickslip
from docutils.nodes import SkipNode
from docutils.utils.math import latex2mathml
from sphinx.errors import ExtensionError

HERE = Path(__file__).parent
# The gallery has its own look, which sphinx-gallery calls by this name.
sys.path.insert(0, str(HERE / "gallery"))
PROGRAM = os.environ.get("STICKSLIP", "stickslip")

project = "stickslip"
author = "stickslip contributors"
release = version = stickslip.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = [
    "_pictures",
    "_templates",
    "gallery",
    "reference/_program.md",
    "requirements.txt",
    # Tables of run times, which load scripts from the network.
    "**sg_execution_times.rst",
]
language = "en"

myst_enable_extensions = ["deflist", "dollarmath", "colon_fence"]
myst_heading_anchors = 3
# What `make docs` puts beside the pages: the report and the documentation of the crates.
myst_url_schemes = {"http": None, "https": None, "site": "{{path}}"}

templates_path = ["_templates"]
default_role = "literal"
autosummary_generate = True
# `state` and `State` are one file where names of files have no case.
autosummary_filename_map = {
    f"stickslip.{name}": f"stickslip.{name}-function"
    for name in stickslip.__all__
    if name.capitalize() in stickslip.__all__ and name.islower()
}
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "_gallery",
    "filename_pattern": r"/plot_",
    "within_subsection_order": "FileNameSortKey",
    "ignore_pattern": r"check\.py",
    "reset_modules": ("matplotlib", "check.apply_style"),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "image_srcset": ["2x"],
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 1e9,
    "remove_config_comments": True,
}

html_theme = "furo"
html_title = "stickslip"
html_copy_source = False
html_show_copyright = False
html_show_sphinx = False
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_theme_options = {"navigation_with_keys": True}
html_math_renderer = "mathml"


def write_program_page(app):
    """Writes the help of each command of the program, as the program prints it."""

    def help_of(*command):
        run = [PROGRAM, *command, "--help"]
        return subprocess.run(run, capture_output=True, text=True, check=True).stdout.strip()

    overview = help_of()
    listed = overview.split("Commands:")[1].split("Options:")[0]
    commands = [name for name in re.findall(r"^  ([a-z-]+) ", listed, re.M) if name != "help"]
    if not commands:
        raise ExtensionError(f"`{PROGRAM} --help` lists no commands")
    sections = [f"```text\n{overview}\n```"]
    sections += [f"## {name}\n\n```text\n{help_of(name)}\n```" for name in commands]
    text = "\n\n".join(sections) + "\n"
    page = HERE / "reference" / "_program.md"
    if not page.exists() or page.read_text(encoding="utf-8") != text:
        page.write_text(text, encoding="utf-8")


# An index of a letter with a dot comes out below both.
DOTTED = r'<munderover>\s*(<mi>\w+</mi>)\s*(.+?)\s*(<mo stretchy="false">.</mo>)\s*</munderover>'
INDEXED = r'<msub><mover accent="true">\1\3</mover>\2</msub>'


def formula(node, as_block):
    return re.sub(DOTTED, INDEXED, latex2mathml.tex2mathml(node.astext(), as_block), flags=re.S)


def visit_inline(self, node):
    self.body.append(formula(node, as_block=False))
    raise SkipNode


def visit_block(self, node):
    self.body.append(f'<div class="formula">{formula(node, as_block=True)}</div>')
    raise SkipNode


def setup(app):
    app.add_html_math_renderer(
        "mathml", inline_renderers=(visit_inline, None), block_renderers=(visit_block, None)
    )
    app.connect("builder-inited", write_program_page)
