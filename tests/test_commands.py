"""What holds for every command, every table of a paper, every picture; and those of one's own."""

import json
from pathlib import Path

import click
import pandas as pd
import pytest

import mcsim
from mcsim import gum
from mcsim.adding import KINDS
from mcsim.cli.commands import COMMANDS
from mcsim.cli.main import exit_code
from mcsim.errors import InputError
from mcsim.figures import PICTURES
from mcsim.papers import (
    FIGURES,
    TABLES,
    allan_recovery,
    attitude_drift,
    repeated_runs,
    velocity_tables,
)
from mcsim.registry import Registry
from mcsim.systems.velocity.raw_log import raw_log
from tests.conftest import BASE_YAML

SCENARIOS = Path(__file__).parent.parent / "scenarios"
A1 = str(SCENARIOS / "velocity" / "a1.yaml")
ENGINE = str(SCENARIOS / "vibration" / "engine.yaml")
#: For each command that writes: its arguments, and the folder that it makes in that of results.
WRITING = {
    "allan": (["curves"], ""),
    "budget": ([A1], "a1-budget"),
    "calibrate": ([A1, "--samples", "20"], "a1-calibration"),
    "characterise": (["sensor.yaml"], ""),
    "figures": (["13"], "figure13"),
    "linearity": ([A1], "a1-linearity"),
    "run": (["case.yaml", "--realizations", "20"], "case"),
    "velocity": (["runs.csv", "--calibration", A1, "--draws", "200"], "runs-velocity"),
    "vibration": ([ENGINE], "engine"),
}
SENSOR = "accelerometer: {velocity_random_walk: 0.1 m/s/√h}\n"


def options(command):
    """The long options of a click command."""
    return [o for p in command.params for o in p.opts if o.startswith("--")]


def commands():
    """Every command by its words; those of groups too."""
    for name in COMMANDS:
        command = COMMANDS[name].command
        yield (name,), command
        if isinstance(command, click.Group):
            context = click.Context(command)
            for inner in command.list_commands(context):
                yield (name, inner), command.get_command(context, inner)


ALL = dict(commands())


@pytest.mark.parametrize("words", ALL, ids=" ".join)
def test_every_command_tells_its_options(words, capsys):
    assert exit_code([*words, "--help"]) == 0
    told = capsys.readouterr().out
    assert f"Usage: mcsim {' '.join(words)} " in told
    for option in options(ALL[words]):
        assert option in told


def test_all_commands_are_listed_with_a_sentence(capsys):
    assert exit_code(["--help"]) == 0
    lines = capsys.readouterr().out.split("Commands:")[1].strip().splitlines()
    assert [line.split()[0] for line in lines] == sorted(COMMANDS)
    assert all(len(line.split()) > 3 for line in lines)


@pytest.mark.parametrize("argument", ["no/such.thing", "--no-such-option"])
@pytest.mark.parametrize("words", ALL, ids=" ".join)
def test_every_command_explains_bad_input(words, argument, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert exit_code([*words, argument]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "Traceback" not in err
    assert "internal error" not in err
    assert not list(tmp_path.iterdir())


def test_every_command_that_writes_is_tried():
    """`plot` draws what has a provenance already; tables are tried below."""
    writing = {words[0] for words, command in ALL.items() if "--output" in options(command)}
    assert writing - {"plot", "table"} == WRITING.keys()


@pytest.mark.slow
@pytest.mark.parametrize("name", WRITING)
def test_every_folder_has_a_provenance(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("case.yaml").write_text(BASE_YAML)
    Path("sensor.yaml").write_text(SENSOR)
    log = raw_log(mcsim.Scenario.from_yaml(A1, ["runs=2"]).base, 1)
    pd.DataFrame(log).to_csv("runs.csv", index=False)
    arguments, folder = WRITING[name]
    assert exit_code([name, *arguments, "--quiet", "--output", "out"]) == 0
    assert capsys.readouterr().out == ""
    refuse_strays(tmp_path / "out" / folder)


def refuse_strays(folder):
    """Every table is one that the provenance tells of."""
    told = json.loads((folder / "provenance.json").read_text())
    assert told["mcsim"] == mcsim.__version__
    tables = {f.name for f in folder.iterdir() if f.suffix in (".csv", ".parquet")}
    assert tables == set(told.get("files", {}))


@pytest.fixture
def quick(monkeypatch):
    """Tables that take seconds, made of less."""
    monkeypatch.setattr(velocity_tables, "GROUPS", 20)
    monkeypatch.setattr(repeated_runs, "GROUPS", 200)
    monkeypatch.setattr(attitude_drift, "REALIZATIONS", 64)
    monkeypatch.setattr(attitude_drift, "TIMES", (10.0,))
    monkeypatch.setattr(allan_recovery, "SENSORS", ("MPU-9250",))
    course = gum.course_of_uncertainty
    monkeypatch.setattr(gum, "course_of_uncertainty", lambda model: course(model, groups=20))


@pytest.mark.slow
@pytest.mark.parametrize("name", TABLES)
def test_every_table_sets_printed_beside_computed(name, tmp_path, quick, capsys):
    del quick
    part = TABLES[name]
    settings = {s.name: "1 s" for s in part.settings if s.name == "duration"}
    found = mcsim.table(name, **settings)
    assert tuple(found.tables) == part.files
    for table in found.tables.values():
        printed = [c for c in table if "printed" in c]
        assert printed
        assert table[printed].notna().any().all()
        assert len(table.select_dtypes("number").columns) > len(printed)
    arguments = [f"--{key}={value}" for key, value in settings.items()]
    assert exit_code(["table", name, *arguments, "--output", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert out.startswith(found.text)
    assert part.files[0] + ".csv" in out
    folder = tmp_path / part.folder
    refuse_strays(folder)
    for file, table in found.tables.items():
        again = pd.read_csv(folder / f"{file}.csv", engine="pyarrow")
        assert list(again) == list(table)
        for column in table.select_dtypes("float"):
            assert again[column].to_numpy() == pytest.approx(
                table[column].to_numpy(), rel=1e-8, nan_ok=True
            )


def test_tables_say_nothing_when_asked_for_quiet(tmp_path, capsys):
    file = tmp_path / "one.csv"
    assert exit_code(["table", "gravity-leakage", "--quiet", "--csv", str(file)]) == 0
    assert capsys.readouterr().out == ""
    assert len(pd.read_csv(file)) == 42


def test_figures_have_something_to_make():
    """Scenarios or a function; folders of their own do not fall together."""
    assert all(FIGURES[name].make or FIGURES[name].scenarios() for name in FIGURES)
    own = [FIGURES[name].own_folder for name in FIGURES]
    assert len(set(own)) == len(own)


OWN = """
import click
import pandas as pd
from matplotlib.figure import Figure

import mcsim

def paint(results):
    figure = Figure()
    values = results.table.query("statistic == 'rms'")["value"]
    figure.subplots().plot(values.to_numpy())
    return figure

mcsim.add(mcsim.Picture("bell", wants=lambda results: True, paint=paint))

def twice(number):
    table = pd.DataFrame({"printed": [2 * number], "computed": [number + number]})
    return mcsim.Computed({"twice": table}, f"twice {number}")

mcsim.add(mcsim.PaperTable("twice", "Twice a number.", twice, files=("twice",),
                           settings=(mcsim.Setting("number", 3, least=1),)))

def make(folder):
    mcsim.Report({"command": "figures 99"}, texts={"figure.txt": "99"}).write(folder)
    return [folder / "figure.txt"]

mcsim.add(mcsim.PaperFigure("99", make=make))

@click.command()
@click.argument("name")
def greet(name):
    '''Greet somebody politely and briefly.'''
    if name == "nobody":
        raise mcsim.InputError("name somebody")
    click.echo(f"good day, {name}")

mcsim.add(mcsim.Command("greet", greet))
"""
LISTS = {"bell": PICTURES, "twice": TABLES, "99": FIGURES, "greet": COMMANDS}


@pytest.fixture
def own(tmp_path, monkeypatch):
    """Runs a command line after the file of a user's own, and forgets its parts again."""
    monkeypatch.chdir(tmp_path)
    Path("own.py").write_text(OWN)

    def run(*arguments):
        try:
            return exit_code(["--with", "own.py", *arguments])
        finally:
            for name, parts in LISTS.items():
                parts.remove(name)

    return run


def test_a_command_of_ones_own(own, capsys):
    assert own("greet", "Ada") == 0
    assert capsys.readouterr().out == "good day, Ada\n"
    assert own("greet", "nobody") == 2
    assert capsys.readouterr().err == "mcsim: name somebody\n"
    assert own("--help") == 0
    assert "Greet somebody politely" in capsys.readouterr().out
    assert exit_code(["greet", "Ada"]) == 2


def test_a_table_of_ones_own(own, capsys):
    assert own("table", "twice", "--number", "21", "--output", "out") == 0
    assert capsys.readouterr().out.startswith("twice 21\n")
    assert pd.read_csv("out/twice.csv")["printed"].tolist() == [42]
    told = json.loads(Path("out/provenance.json").read_text())
    assert (told["command"], told["options"]) == ("table twice", {"number": 21})
    assert own("table", "twice", "--number", "0") == 2


def test_a_figure_of_ones_own(own, capsys):
    assert own("figures", "99", "--output", "out") == 0
    assert capsys.readouterr().out == "out/figure99/figure.txt\n"
    assert own("figures", "98") == 2
    assert '"98" is not one of 1, 2' in capsys.readouterr().err


@pytest.mark.slow
def test_a_picture_of_ones_own(own, capsys):
    Path("case.yaml").write_text(BASE_YAML.replace("200", "20"))
    assert own("run", "case.yaml", "--output", "out") == 0
    folder = Path("out/case")
    assert (folder / "bell.png").stat().st_size > 5000
    assert (folder / "figure.png").exists()
    before = (folder / "bell.png").read_bytes()
    assert own("plot", "out/case") == 0
    assert "bell.svg" in capsys.readouterr().out
    assert (folder / "bell.png").read_bytes() == before
    # Without it, and with new tables, an old picture does not stay; others' files do.
    assert own("run", "case.yaml", "--no-figures", "--output", "out") == 0
    assert not list(folder.glob("*.png"))


@pytest.mark.parametrize("kind", KINDS)
def test_parts_of_every_kind_come_by_mcsim_add(kind):
    """Their types are public names; what is none is refused."""
    assert kind in mcsim._WHERE
    assert isinstance(getattr(mcsim, kind), type)
    with pytest.raises(InputError, match=kind):
        mcsim.add(5)


def test_a_name_that_is_taken_is_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("own.py").write_text(
        "import mcsim\nmcsim.add(mcsim.Picture('tracks', lambda r: True, lambda r: None))\n"
    )
    assert exit_code(["--with", "own.py", "sensors"]) == 2
    assert "there is a picture of that name already" in capsys.readouterr().err
    assert isinstance(PICTURES, Registry)
    assert list(PICTURES) == ["figure", "map", "tracks"]


def test_own_parts_do_not_run_on_other_machines(own, capsys):
    Path("case.yaml").write_text(BASE_YAML)
    assert own("run", "case.yaml", "--dask", "tcp://127.0.0.1:1") == 2
    assert "not with --dask" in capsys.readouterr().err
