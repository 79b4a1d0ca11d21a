"""Numbers of the validation pages: those pages are templates, whose tables and figures are read from stored results.

Results stand in outputs/gallery, as the commands left them, and in docs/data: tables of single runs, each with the
command that makes it in its first line.
"""

import html
import re
from pathlib import Path

import jinja2
import pandas as pd
from mkdocs.structure.files import File

ROOT = Path(__file__).parents[2]
GALLERY, DATA = ROOT / "outputs" / "gallery", ROOT / "docs" / "data"
PAGES = "validation/"
SECTION = re.compile(r"^## (.+)$", re.MULTILINE)


def on_files(files, config, **_):
    """Figures and tables of the gallery become files of the site."""
    for source in sorted(GALLERY.iterdir()):
        if source.suffix in (".png", ".csv"):
            files.append(File.generated(config, f"gallery/{source.name}", abs_src_path=str(source)))
    return files


def on_page_markdown(markdown: str, page, **_) -> str:
    """A page of results, with its numbers."""
    if not page.file.src_uri.startswith(PAGES):
        return markdown
    return rendered(markdown)


def rendered(template: str) -> str:
    """A template with its numbers.

    Raises
    ------
    jinja2.UndefinedError, KeyError, ValueError
        if it asks for what is not there.

    """
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, autoescape=False, keep_trailing_newline=True)
    environment.globals.update(
        table=table, number=number, count=count, total=total, values=values, pivot=pivot, figure=figure,
        statements=statements, verdicts=verdicts, fidelities=fidelities, command=command,
    )  # fmt: skip
    return environment.from_string(template).render()


# --- what templates use -----------------------------------------------------------------------------------------------


def table(name: str, columns: dict[str, str | tuple] | None = None, **where) -> str:
    """Rows of a CSV file as a table.

    Parameters
    ----------
    name : of the file.
    columns : heading and column of each; a tuple (column, decimals, factor) for numbers; None for all as they are.
    where : values that rows must have in columns, or lists of them.

    """
    rows = chosen(read(name), where)
    columns = columns or {column: column for column in rows.columns}
    body = [[cell(row, spec) for spec in columns.values()] for _, row in rows.iterrows()]
    return lines(list(columns), body)


def number(name: str, column: str, decimals: int | None = None, factor: float = 1.0, **where) -> str:
    """The one number that a file has in a column, in the row with these values."""
    rows = chosen(read(name), where)
    if len(rows) != 1:
        raise ValueError(f"{name} has {len(rows)} rows with {where}; it must be one")
    return cell(rows.iloc[0], column if decimals is None else (column, decimals, factor))


def count(name: str, **where) -> int:
    """How many rows a file has with these values."""
    return len(chosen(read(name), where))


def total(name: str, column: str, **where) -> int:
    """Sum of the whole numbers that a file has in a column, in the rows with these values."""
    return sum(map(int, chosen(read(name), where)[column]))


def values(name: str, column: str) -> list[str]:
    """What stands in a column, each once, in its order."""
    return list(dict.fromkeys(read(name)[column]))


def pivot(name: str, rows: str, columns: str, value: str, unit: str, miss: str, **where) -> str:
    """Values by two of their names; those that miss their bound, which ends each row or column, have a cross."""
    found = chosen(read(name), where)
    heads, sides = list(dict.fromkeys(found[columns])), list(dict.fromkeys(found[rows]))
    body = []
    for side in sides:
        mine = found[found[rows] == side].set_index(columns)
        cells = []
        for head in heads:
            there = mine.loc[[head]].iloc[0] if head in mine.index else None
            text = "" if there is None or pd.isna(there[value]) else f"{float(there[value]):.3g}"
            cells.append(text if there is None or str(there[miss]) == "True" else f"{text or 'no number'} ✗")
        bounds = {f"{row.bound} {'' if row[unit] == '-' else row[unit]}".strip() for _, row in mine.iterrows()}
        body.append([side, *cells, *([bounds.pop().replace("<=", "≤").replace(">=", "≥")] if len(bounds) == 1 else [])])
    bounded = all(len(row) == len(heads) + 2 for row in body)
    return lines([rows, *heads, *(["bound"] if bounded else [])], [row[: len(heads) + 1 + bounded] for row in body])


def figure(name: str, caption: str) -> str:
    """A figure of the gallery."""
    if not (GALLERY / name).exists():
        raise ValueError(f"outputs/gallery has no {name}")
    words = html.escape(re.sub(r"[*`_$]", "", caption), quote=True)
    picture = f"![{words}](../gallery/{name}){{ loading=lazy }}"
    return f'<figure markdown="span">\n{picture}\n<figcaption>{caption}</figcaption>\n</figure>'


def statements() -> str:
    """The paper's statements, section by section."""
    text = (GALLERY / "paper_table.md").read_text(encoding="utf-8")
    return SECTION.sub(r"### \1", text[text.index("## Section") :]).replace("**", "")


def verdicts() -> dict[str, int]:
    """How many of the paper's statements agree, and how many do not."""
    line = (GALLERY / "paper_table.md").read_text(encoding="utf-8").splitlines()[2]
    whole, _, parts = line.partition(" statements: ")
    found = {name: int(many) for name, many in (part.rsplit(" ", 1) for part in parts.rstrip(".").split(", "))}
    return {"all": int(whole)} | found


def fidelities() -> str:
    """The named settings in each scene of the chart: largest error of P, T and N over the weight, and cost."""
    rows, truth = read("chart.csv"), read("truth.csv")
    body = []
    for scene in dict.fromkeys(rows["scene"]):
        some = rows[(rows["scene"] == scene) & (rows["dial"] == "fidelity")]
        bars = truth[(truth["scene"] == scene) & truth["quantity"].isin(["P_residual", "T_residual", "N_residual"])]
        cells = [f"{percent(row.forces)} · {float(row.core_seconds):.3g} s" if row.forces else "–"
                 for row in some.itertuples()]  # fmt: skip
        body.append([scene, *cells, f"± {percent(bars['relative_error'].astype(float).max())}"])
    return lines(["scene", *dict.fromkeys(rows[rows["dial"] == "fidelity"]["setting"]), "known to"], body)


def percent(value: str | float) -> str:
    """A share as a percentage of two digits."""
    return f"{100.0 * float(value):.2g} %"


def command(name: str) -> str:
    """What makes a table of docs/data."""
    return (DATA / name).read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")


# --- how they do it ---------------------------------------------------------------------------------------------------


def read(name: str) -> pd.DataFrame:
    """A table as text, so that numbers stay as they were written."""
    file = next((folder / name for folder in (GALLERY, DATA) if (folder / name).exists()), None)
    if file is None:
        raise ValueError(f"neither outputs/gallery nor docs/data has {name}")
    return pd.read_csv(file, dtype=str, keep_default_na=False, comment="#" if file.parent == DATA else None)


def chosen(rows: pd.DataFrame, where: dict) -> pd.DataFrame:
    """Those with these values."""
    for column, value in where.items():
        values = [str(one) for one in value] if isinstance(value, (list, tuple)) else [str(value)]
        unknown = set(values) - set(rows[column])
        if unknown:
            raise ValueError(f"{column} is never {', '.join(sorted(unknown))}")
        rows = rows[rows[column].isin(values)]
    return rows


def cell(row: pd.Series, spec: str | tuple) -> str:
    """One value as text."""
    column, decimals, factor = (*spec, 1.0)[:3] if isinstance(spec, tuple) else (spec, None, 1.0)
    text = row[column]
    if decimals is None or text in ("", "nan"):
        return "–" if text in ("", "nan") else text
    return f"{factor * float(text):.{decimals}f}".replace("-", "−")


def lines(heads: list, body: list[list]) -> str:
    """A table in Markdown."""
    rows = [heads, ["---"] * len(heads), *body]
    return "\n".join("| " + " | ".join(str(one).replace("|", "\\|") for one in row) + " |" for row in rows)
