"""Run files that `arcref calibrate` must refuse: one line on stderr, exit status 2, no file written."""


def refusal(arcref, method: str, folder, content: bytes | str) -> str:
    """Have `content` calibrated, and give what stands behind the file's name in the only line that was printed."""
    path = folder / "run.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    wanted = {"-o": "cal.json", "--json": "x.json", "--csv": "x.csv", "--report": "x.html"}
    outputs = (part for option, name in wanted.items() for part in (option, folder / name))
    result = arcref("calibrate", method, path, *outputs)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith(f"arcref: {path}")
    assert [file.name for file in folder.iterdir()] == ["run.csv"]
    return result.stderr.removeprefix(f"arcref: {path}").removesuffix("\n")
