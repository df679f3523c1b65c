"""The commands of Gazebo's `gz`: those that libgz has, and what serves instead of the others."""

import pytest
from lxml import etree

from libgz.apps.libgz import COMMANDS, WITHOUT, main
from libgz.classic.log import LogReader, LogWriter, read_states
from libgz.sdf.description import VERSIONS

GZ = [
    "camera",
    "debug",
    "help",
    "joint",
    "log",
    "marker",
    "model",
    "physics",
    "sdf",
    "stats",
    "topic",
    "world",
]  # `gz help` of 11.1
OPTIONS = {  # of `gz help COMMAND`
    "sdf": "-d --describe -c --convert -o --doc -k --check -v --version -p --print",
    "debug": "-o --option",
    "log": "-i --info -e --echo -d --record -w --world-name -z --hz -f --file -o --output -n --encoding --filter",
    "stats": "-w --world-name -d --duration -p --plot",
    "topic": "-w --world-name -l --list -i --info -e --echo -v --view -z --hz -b --bw -p --publish -r --request -u "
    "--unformatted -d --duration -m --msg -f --file",
    "world": "-w --world-name -p --pause -s --step -m --multi-step -r --reset-all -t --reset-time -o --reset-models",
    "physics": "-w --world-name -g --gravity -s --step-size -i --iters -u --update-rate -o --profile",
    "joint": "-w --world-name -m --model-name -j --joint-name -f --force --pos-t --pos-p --pos-i --pos-d --vel-t "
    "--vel-p --vel-i --vel-d",
    "model": "-m --model-name -w --world-name -d --delete -f --spawn-file -s --spawn-string -i --info -p --pose -x "
    "--pose-x -y --pose-y -z --pose-z -R --pose-R -P --pose-P -Y --pose-Y",
}


def run(*words):
    try:
        return main(list(words))
    except SystemExit as error:
        return error.code


@pytest.mark.parametrize("verb", GZ)
def test_every_verb_of_gz_is_a_command_or_says_what_serves_instead(verb, capsys):
    assert (verb in COMMANDS) or (verb in WITHOUT) or verb == "help"
    if verb in WITHOUT:
        assert run(verb, "-l") == run("help", verb) == 2
        one, two = capsys.readouterr().err.splitlines()
        assert one == two == f"libgz: there is no {verb!r}: {WITHOUT[verb]}"


@pytest.mark.parametrize("verb", OPTIONS)
def test_debug_lists_the_options_of_gz(verb, capsys):
    assert run("debug", "-o", verb) == 0
    assert set(OPTIONS[verb].split()) <= set(capsys.readouterr().out.split())


def test_debug_lists_the_commands_and_nothing_for_an_unknown_one(capsys):
    assert run("debug") == 0
    assert capsys.readouterr().out.split() == sorted([*COMMANDS, "help"])
    assert run("debug", "-o", "nothing") == 0
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("version", VERSIONS)
def test_sdf_describes_each_version(version, capsys):
    assert run("sdf", "-d", "-v", version) == 0
    text = capsys.readouterr().out
    root = etree.fromstring(text.replace(" =", "="))
    assert root.get("name") == "sdf"
    link = "element[@name='model']/element[@name='link']/element[@name='inertial']/element[@name='mass']"
    assert [e.attrib for e in root.findall(link)] == [
        {"name": "mass", "required": "0", "type": "double", "default": "1"}
    ]
    assert [e.get("default") for e in root.findall("element[@name='light']/element[@name='cast_shadows']")] == ["0"]
    assert run("sdf", "-o", "-v", version) == 0
    page = capsys.readouterr().out
    assert page.startswith("<!DOCTYPE html>")
    assert page.count("<details") == page.count("</details>") > 500
    assert "http" not in page


def test_a_model_in_a_model_refers_to_it(capsys):
    run("sdf", "-d", "-v", "1.6")
    assert "<element ref ='model' required ='*'/>" in capsys.readouterr().out


def test_sdf_converts_a_file_in_place(tmp_path, capsys):
    path = tmp_path / "a.sdf"
    path.write_text("<sdf version='1.4'><model name='m'><link name='l'/></model></sdf>")
    assert run("sdf", "-c", str(path)) == 0
    assert capsys.readouterr().out == "Success\n"
    assert "version='1.6'" in path.read_text().replace('"', "'")
    assert run("sdf", "-k", str(path)) == 0
    assert capsys.readouterr().out == "Check complete\n"
    assert run("sdf", "-p", str(path)) == 0
    assert '<link name="l"/>' in capsys.readouterr().out
    assert run("sdf", "-p", str(path), "-v", "1.6") == 1
    assert "-v goes with -d and -o" in capsys.readouterr().err


def test_a_window_of_topics_is_refused_in_one_sentence(capsys):
    assert run("topic", "-v", "~/pose/info") == 1
    assert capsys.readouterr().err.startswith("libgz: there is no window that shows topics: use -e ~/pose/info, ")


def test_log_writes_chosen_states_to_another_file(tmp_path, capsys):
    source = tmp_path / "state.log"
    document = "<sdf version='1.6'>{}</sdf>\n"
    pose = "<model name='{}'><link name='l'><pose>0 0 {} 0 0 0</pose></link></model>"
    with LogWriter(source, "bz2", 7) as log:
        log.add(document.format("<world name='w'><model name='a'/><model name='b'/></world>"))
        for i in range(5):
            inside = f"<sim_time>0 {i}00000000</sim_time>{pose.format('a', i)}{pose.format('b', 2 * i)}"
            log.add(document.format(f"<state world_name='w'>{inside}</state>"))
    target = tmp_path / "other.log"
    assert run("log", "-f", str(source), "-o", str(target), "--filter", "b", "-z", "5") == 0
    reader = LogReader(target)
    states = list(read_states(reader))
    assert [state.sim_time for state in states] == pytest.approx([0.0, 0.2, 0.4])
    assert all(set(state.poses) == {"b::l"} for state in states)
    assert (reader.header.rand_seed, next(reader.chunks())[0]) == (7, "bz2")
    assert next(reader.documents()).find("world").get("name") == "w"
    assert run("log", "-f", str(source), "-o", str(target), "-n", "txt") == 0
    assert next(LogReader(target).chunks())[0] == "txt"
    copied, whole = ([s.text("1.6") for s in read_states(LogReader(path))] for path in (target, source))
    assert copied == whole
    capsys.readouterr()
    assert run("log", "-f", str(source), "-o", str(source)) == 1
    assert "the log itself; name another file" in capsys.readouterr().err
