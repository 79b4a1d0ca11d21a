"""`taichi-silo list`."""

from taichi_silo.cli.output_flags import JsonFlag
from taichi_silo.utils.console import Console


def command(json: JsonFlag = False) -> None:
    """List the scenarios that can be run, and the published sands."""
    from rich.table import Table

    from taichi_silo.cli import catalogue
    from taichi_silo.scene.published_sands import published as published_sands

    found, published = catalogue.scenarios(), published_sands()
    console = Console(as_json=json)
    if json:
        console.result({"scenarios": found, "sands": {name: sand["title"] for name, sand in published.items()}})
        return
    for title, rows in (
        ("taichi-silo run SCENARIO", found),
        ("--sand NAME", {name: f"{sand['title']} ({sand['source']})" for name, sand in published.items()}),
    ):
        table = Table(title=title, title_justify="left", show_header=False, box=None, pad_edge=False)
        table.add_column(no_wrap=True)
        table.add_column()
        for name, words in rows.items():
            table.add_row(name, words)
        console.terminal.print(table)
        console.say("")
