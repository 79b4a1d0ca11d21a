"""The days on which the locked versions were released: a table beside the code, made with the lock (`make lock`)."""

import csv
import sys
import tomllib
from datetime import date
from pathlib import Path

TABLE = Path(__file__).with_name("released.csv")


def write(pylock: Path) -> None:
    """Take the days out of a pylock.toml: those of the oldest file of each package."""
    packages = tomllib.loads(pylock.read_text(encoding="utf-8"))["packages"]
    with open(TABLE, "w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(("package", "version", "released"))
        for one in packages:
            files = [*one.get("wheels", ()), *([one["sdist"]] if "sdist" in one else [])]
            days = [file["upload-time"].date() for file in files if "upload-time" in file]
            writer.writerow((one["name"], one["version"], min(days) if days else ""))


def read() -> dict[tuple[str, str], date]:
    """Day of release by package and version, as far as they are known."""
    with open(TABLE, encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    return {(row["package"], row["version"]): date.fromisoformat(row["released"]) for row in rows if row["released"]}


if __name__ == "__main__":
    write(Path(sys.argv[1]))
