"""Reads what the interface (api.*) and the command (own.*) exported, with pandas and with DuckDB, and compares."""

import sys
from pathlib import Path

import duckdb
import pandas

work = Path(sys.argv[1])
frames = {}
for name in ("api", "own"):
    parquet = pandas.read_parquet(work / f"{name}.parquet")
    csv = pandas.read_csv(work / f"{name}.csv", parse_dates=["time"])
    assert list(parquet.columns) == list(csv.columns), "the forms have the same columns"
    assert str(parquet["time"].dtype).startswith("datetime64") and parquet["time"].dt.tz is not None, parquet["time"].dtype
    both = parquet.merge(csv, on=["time", "wagon"], suffixes=("", "_csv"))
    # The train runs on between two exports: each wagon's newest step may have taken samples in since.
    grown = both["samples"] != both["samples_csv"]
    newest = both.groupby("wagon")["time"].transform("max") == both["time"]
    assert not (grown & ~newest).any(), f"{name}: {both[grown & ~newest]}"
    both = both[~newest]
    assert len(both) >= 15, len(both)
    for column in ("v_m_s", "adhesion_low", "wheelset_1_slide_energy_j_max"):
        difference = (both[column] - both[f"{column}_csv"]).abs().max()
        assert not difference > 1e-4 * both[column].abs().max(), f"{name}.{column}: {difference}"
    frames[name] = parquet
    for file in (work / f"{name}.parquet", work / f"{name}.csv"):
        rows, wagons, begin, fastest = duckdb.sql(
            f"SELECT count(*), count(DISTINCT wagon), min(time), max(v_m_s_max) FROM '{file}'"
        ).fetchall()[0]
        print(f"{file.name}: {rows} rows, {wagons} wagons from {begin}, at most {fastest:.1f} m/s")
        assert wagons == 3 and rows >= 20 and 1 < fastest < 100
        assert "TIMESTAMP" in str(duckdb.sql(f"SELECT time FROM '{file}' LIMIT 1").types[0])
    assert ((parquet["v_m_s_min"] <= parquet["v_m_s_max"]) | parquet["v_m_s"].isna()).all()
same = frames["api"].merge(frames["own"], on=["time", "wagon"])
closed = same[same["samples_x"] == same["samples_y"]]
assert len(closed) >= 15 and (closed["v_m_s_x"] == closed["v_m_s_y"]).all(), "interface and command agree"
print(f"{len(closed)} rows are the same by the interface and by the command")
