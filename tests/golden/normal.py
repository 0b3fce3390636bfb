# SPDX-License-Identifier: Apache-2.0
"""What two runs of one program write alike: files and messages without times, memory, versions and places."""
import gzip
import json
import pathlib
import re
import sqlite3
import tempfile

# Measured by the run itself, wherever it stands in summary.json and in what --json prints; what stands for it can be
# read as a result.
MEASURED = {"wall_s": 0.25, "peak_mib": 64.0, "gain": 1.5, "simplified_gain": 1.5, "version": "VERSION"}
# In a report: the times of all stages, and the row of a comparison.
STAGES = re.compile(r"<h2>Time and memory</h2>[^\0]*?</table>|(?<=<tr><td>wall time \[s\]</td>).*")
GAIN = re.compile(r"\b\d+\.\d+(?=\s+times\s+as\s+fast)")
VERSION = re.compile(r"\bsarblock \d+\.\d+\.\d+[\w.+-]*")
# The time of writing in the first line of SINEX, in the contents of a GeoPackage and in the head of an orbit file.
WRITTEN = re.compile(r"(?<=^%=SNX 2\.02 ...) \d\d:\d{3}:\d{5}|'\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.000Z'|"
                     r"(?<=<Creation_Date>)[^<]*|(?<=<Creator_Version>)[^<]*")


def text(value, places):
    """`places` are folders of this computer, each with the word that stands for it."""
    for place, word in places:
        value = value.replace(str(place), word)
    return GAIN.sub("#", VERSION.sub("sarblock VERSION", value))


def without_measured(value):
    if isinstance(value, dict):
        return {key: without_measured(item) if item is None or key not in MEASURED else MEASURED[key]
                for key, item in value.items()}
    if isinstance(value, list):
        return [without_measured(item) for item in value]
    return value


def of_json(value, places):
    return text(json.dumps(without_measured(json.loads(value)), indent=1, ensure_ascii=False) + "\n", places)


def of_geopackage(data):
    """The rows of all tables: the bytes of the file depend on the version of SQLite."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "a.gpkg"
        file.write_bytes(data)
        database = sqlite3.connect(file)
        database.text_factory = lambda raw: raw.decode("utf-8", "replace")
        try:
            rows = []
            tables = database.execute("SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name").fetchall()
            for table in (name for (name,) in tables if not name.startswith("rtree_")):
                cursor = database.execute(f'SELECT * FROM "{table}"')
                rows.append(f"{table}: " + ",".join(column[0] for column in cursor.description))
                for row in cursor:
                    rows.append(",".join(cell.hex() if isinstance(cell, bytes) else repr(cell) for cell in row))
        finally:
            database.close()
    return WRITTEN.sub("WRITTEN", "\n".join(rows) + "\n")


def of_file(name, data, places):
    """The normal form, in bytes, of a file of that name."""
    if name.endswith(".gz"):
        name, data = name.removesuffix(".gz"), gzip.decompress(data)
    if name.endswith(".gpkg"):
        return of_geopackage(data).encode("utf-8")
    if name.endswith((".h5", ".net", ".cub")):
        return data
    try:
        value = data.decode("utf-8")
        if name.endswith((".json", ".geojson")):
            return of_json(value, places).encode("utf-8")
        if name.endswith(".html"):
            value = STAGES.sub("", value)
        elif name.endswith((".snx", ".EOF")):
            value = WRITTEN.sub("WRITTEN", value)
        return text(value, places).encode("utf-8")
    except ValueError:  # neither text nor JSON
        return data
