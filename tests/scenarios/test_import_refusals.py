"""Maps that are malformed are refused with the line and column, the pixel or the field; damaged ones never crash."""

# ruff: noqa: E501 - tables

from __future__ import annotations

import base64
import copy
import json
import random
import re
import struct
import warnings
import zlib
from pathlib import Path

import map_files
import pytest
from typer.testing import CliRunner

from colonysim import import_map
from colonysim.cli import app
from colonysim.errors import ColonysimError, ColonysimWarning
from colonysim.installing import install_command

MAPS = Path(__file__).parent / "maps"


def refused(folder: Path, name: str, content: bytes, **options) -> str:
    """What a file is refused with, without its folder."""
    path = folder / name
    path.write_bytes(content)
    with pytest.raises(ColonysimError) as found:
        import_map(path, **options)
    message = str(found.value)
    assert "\n" not in message
    return message.replace(f"{folder}/", "")


def movingai(text: str) -> bytes:
    return text.replace("/", "\n").encode("latin-1")


MOVINGAI = [
    ("", "x.map:1:1: nothing stands here, expected `type octile`"),
    ("height 2/width 2/map/../..", "x.map:1:1: 'height 2', expected `type octile`"),
    ("type hex/height 2/width 2/map/../..", "x.map:1:6: a map of the type 'hex', expected octile or tile"),
    ("type octile/width 2/map/../..", "x.map:3:1: the map begins here, expected `height ...` before it"),
    ("type octile/height 2/height 2/map/../..", "x.map:3:1: 'height 2', expected `width ...`"),
    ("type octile/height 2/depth 2/map/../..", "x.map:3:1: 'depth 2', expected `width ...`"),
    ("type octile/height two/width 2/map/../..", "x.map:2:8: 'two', expected the height in squares, a whole number from 1"),
    ("type octile/height 2/width  -2/map/../..", "x.map:3:8: '-2', expected the width in squares, a whole number from 1"),
    ("type octile/height 2/width 0/map/../..", "x.map:3:7: '0', expected the width in squares"),
    ("type octile/height 2/width 2/../..", "x.map:4:1: '..', expected `map`"),
    ("type octile/height 2", "x.map:2:1: the file ends in its header, expected `width ...`"),
    ("type octile/height 3/width 2/map/../../", "x.map:7:1: the map ends after 2 rows, expected 3 as `height` says"),
    ("type octile/height 3/width 2/map/../..", "x.map:7:1: the map ends after 2 rows, expected 3 as `height` says"),
    ("type octile/height 2/width 2/map/../../..", "x.map:7:1: '..' stands below the last row, as `height` is 2"),
    ("type octile/height 2/width 3/map/.../..", "x.map:6:3: the row has 2 squares, expected 3 as `width` says"),
    ("type octile/height 2/width 2/map/.../..", "x.map:5:3: the row has 3 squares, expected 2 as `width` says"),
    ("type octile/height 2/width 3/map/.../.#.", "x.map:6:2: '#', expected one of . G S @ O T W"),
    ("type octile/height 2/width 3/map/..\xe9/...", "x.map:5:3: 'é', expected one of . G S @ O T W"),
    ("type octile/height 2/width 2/map/@T/WO", "x.map: no floor among 2 x 2 squares, expected some"),
    ("type octile/height 1/width 4/map/..@.", "x.map: 4 agents, but 1 squares of floor are free for 4 of them"),
    ("type octile/height 99999/width 99999/map/..", "x.map: 99999 x 99999 squares are 9999800001, expected at most 16777216"),
    ("type octile/height 9999999999/width 2/map/..", "x.map:2:8: '9999999999', expected the height in squares"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "message"), MOVINGAI)
def test_movingai(text, message, tmp_path):
    assert refused(tmp_path, "x.map", movingai(text)).startswith(message)


SOKOBAN = [
    ("", {}, "x.xsb:1:1: there is no level in this file"),
    ("Just some text; no #1 level", {}, "x.xsb:1:1: there is no level in this file"),
    ("####/#$.#/####", {}, "x.xsb:1:1: level 1 has no player, expected one @"),
    ("; two/#####/#@ @#/#####", {}, "x.xsb:3:4: a second player, the first is at x.xsb:3:2"),
    ("#####/#@.+#/#####", {}, "x.xsb:2:4: a second player, the first is at x.xsb:2:2"),
    ("#######/#@ $..#/#######", {}, "x.xsb:1:1: level 1 has 2 storage squares and only 1 box, expected a box for each"),
    ("#######/#@ $..#/#######/#$$$$$#/#######", {}, "x.xsb:1:1: level 1 has 2 storage squares and only 1 box"),
    ("#####/#@x #/#####", {}, "x.xsb:2:3: 'x' in a row of a level, expected one of # @ + $ * . and blanks for floor"),
    ("#####/#@\t #/#####", {}, "x.xsb:2:3: '\\t' in a row of a level"),
    ("#####/#@  é/#####", {}, "x.xsb:2:5: 'é' in a row of a level"),
    ("5#/#@2y#/5#", {}, "x.xsb:2:4: 'y' in a row of a level"),
    ("5#/#@-7|5#", {}, "x.xsb:2:4: '7' in a row of a level"),
    ("5#/#--@(2-)#|5#", {}, "x.xsb:2:5: '(' in a row of a level"),
    ("#####/#@  /#####", {}, "x.xsb:2:2: the player can leave the board here, expected walls all around"),
    ("#####/#@  #/# ###/", {}, "x.xsb:3:2: the player can leave the board here"),
    ("#####/#@  #/#####", {"level": 2}, "x.xsb: level 2, but the file has one level"),
    ("#####/#@  #/#####//; 2/#####/#@  #/#####", {"level": 3}, "x.xsb: level 3, but the file has 2 levels"),
    ("#####/#@  #/#####", {"level": 0}, "level: 0, expected a whole number from 1"),
    ("#####/#@$.#/#####", {}, "x.xsb: no square of floor is free for the goal"),
    ("####/#+$#/####", {}, "x.xsb:2:2: the player stands on a storage square, and no square is free for the agent"),
    ("######/#@ $.#/######", {"goal": (4, 1)}, "x.xsb:2:5: the goal at 4,1 shares its square with a hole"),
    ("######/#@ $.#/######", {"goal": (3, 1)}, "x.xsb:2:4: the goal at 3,1 shares its square with a box"),
    ("######/#@ $.#/######", {"goal": (5, 1)}, "goal: 5,1 is wall (x.xsb:2:6), expected floor"),
    ("######/#@   #/######", {"agents": [(1, 1)]}, "x.xsb:2:2: a second agent on this square, expected one"),
    ("#####/#@999999999-#/#####", {}, "x.xsb:2:3: the level has more than 16777216 squares"),
    ("#####/#@99999999999999999999-#/#####", {}, "x.xsb:2:3: the level has more than 16777216 squares"),
    ("9999#|" * 20 + "/" + "#|" * 9999 + "#@#", {}, "x.xsb:1:1: 9999 x 10"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "options", "message"), SOKOBAN, ids=[str(n) for n in range(len(SOKOBAN))])
def test_sokoban(text, options, message, tmp_path):
    assert refused(tmp_path, "x.xsb", text.replace("/", "\n").encode(), **options).startswith(message)


def test_more_boxes_than_storage_squares_are_welcome_and_what_the_player_cannot_reach_is_left_out(tmp_path):
    path = tmp_path / "x.xsb"
    path.write_text("########\n#@ $$. #\n########\n#..*$#\n######\n")
    with pytest.warns(UserWarning, match="left out here, which no floor joins") as told:
        document = import_map(path)
    assert [str(each.message).rpartition("/")[2].split(" are ")[0] for each in told] == ["x.xsb:4:4: 2 boxes", "x.xsb:4:2: 3 holes"]
    assert (len(document["boxes"]), len(document["holes"]), document["goal"]) == (2, 1, 8 * 3 + 6)


def test_a_player_on_a_storage_square_starts_beside_it(tmp_path):
    path = tmp_path / "x.xsb"
    path.write_text("#######\n#+$   #\n#######\n")
    assert import_map(path, goal=(5, 1))["agents"] == [7 + 3]


WHITE, BLACK, RED, GREEN = (bytes(map_files.COLOURS[kind]) for kind in ".#ag")
SOUND = map_files.png(3, 2, 8, 2, [RED + WHITE + GREEN, WHITE * 3])


def rgb(*rows: bytes) -> bytes:
    return map_files.png(len(rows[0]) // 3, len(rows), 8, 2, list(rows))


PICTURES = [
    (b"", {}, "x.png: is no PNG picture"),
    (b"GIF89a" + bytes(40), {}, "x.png: is no PNG picture"),
    (SOUND[:20], {}, "x.png: the picture is cut off or damaged: its header is missing"),
    (SOUND[:-20], {}, "x.png: the picture is cut off or damaged"),
    (SOUND[:50], {}, "x.png: the picture is cut off or damaged"),
    (SOUND[:60] + b"\x55" + SOUND[61:], {}, "x.png: the picture is cut off or damaged"),
    (map_files.png(3, 4, 8, 2, [WHITE * 3] * 3), {}, "x.png: the picture is cut off or damaged"),
    (map_files.png(3, 2, 3, 2, [WHITE * 3] * 2), {}, "x.png: the picture is cut off or damaged"),
    (map_files.png(0, 0, 8, 2, []), {}, "x.png: the picture is cut off or damaged"),
    (map_files.png(100_000, 100_000, 8, 2, [WHITE]), {}, "x.png: 100000 x 100000 squares are 10000000000, expected at most 16777216"),
    (rgb(WHITE * 3, WHITE + b"\x01\x02\x03" + WHITE), {}, "x.png: pixel 1, 1: the colour #010203 has no meaning, the nearest that has one is #000000 (wall), 3 away"),
    (rgb(WHITE * 2 + b"\xff\xff\xfe", b"\x01\x02\x03" + WHITE * 2), {}, "x.png: pixel 2, 0: the colour #fffffe has no meaning"),
    (rgb(WHITE * 2 + b"\x40\x40\x40"), {"tolerance": 64}, "x.png: pixel 2, 0: the colour #404040 is as near to #000000 (wall) and #808080 (hole)"),
    (rgb(WHITE + GREEN + WHITE, GREEN + WHITE * 2), {}, "x.png: pixel 0, 1: a second goal, the first is at x.png: pixel 1, 0"),
    (map_files.png(3, 1, 8, 6, [RED + b"\xff" + WHITE + b"\x80" + WHITE + b"\xff"]), {}, "x.png: pixel 1, 0: the colour #ffffff with an opacity of 128 of 255, expected 0 or 255"),
    (rgb(BLACK * 3, BLACK * 3), {}, "x.png: no floor among 3 x 2 squares"),
    (rgb(RED + BLACK + GREEN), {}, "x.png: pixel 0, 0: no way leads the agent from here to the goal at x.png: pixel 2, 0: no floor joins them"),
    (rgb(RED + b"\x80\x80\x80" + GREEN), {}, "x.png: pixel 0, 0: no way leads the agent from here to the goal at x.png: pixel 2, 0: only holes join them, and there are no boxes"),
    (rgb(RED * 2 + WHITE), {"agents": 1}, "agents: 1, but the map has 2; expected at least as many"),
    (SOUND, {"colours": {"#12345": "floor"}}, "colours: '#12345' is no colour, expected one such as #c0c0c0, or transparent"),
    (SOUND, {"colours": {"red": "floor"}}, "colours: 'red' is no colour"),
    (SOUND, {"colours": {"#123456": "flor"}}, "colours: #123456 cannot mean 'flor'; did you mean 'floor'?"),
    (SOUND, {"colours": ["#123456"]}, "colours: ['#123456'], expected a mapping from colours to meanings"),
    (SOUND, {"tolerance": 256}, "tolerance: 256, expected a whole number from 0 to 255"),
    (SOUND, {"level": 1}, "level: only Sokoban files have levels, and this is read as png"),
    (SOUND, {"floor": "."}, "floor: only of MovingAI maps"),
    (SOUND, {"goal": (2, 2)}, "goal: row: 2, expected a whole number from 0 to 1"),
    (SOUND, {"goal": (2,)}, "goal: (2,), expected a column and a row"),
    (SOUND, {"crop": (0, 0, 3, 0)}, "crop: x1: 3, expected a whole number from 0 to 2"),
    (SOUND, {"crop": (2, 0, 1, 0)}, "crop: 2,0,1,0, expected the smaller column and row first"),
    (SOUND, {"crop": (1, 2)}, "crop: (1, 2), expected x0, y0, x1 and y1"),
    (SOUND, {"spacing": 0}, "spacing: 0, expected a number from 1e-06"),
    (SOUND, {"seed": -1}, "seed: -1"),
    (SOUND, {"agents": 7}, "x.png: 7 agents, but 4 squares of floor are free for 6 of them"),
    (SOUND, {"agents": []}, "agents: an empty list"),
    (SOUND, {"agents": [(2, 0)]}, "x.png: pixel 2, 0: the agent at 2,0 shares its square with a goal"),
    (SOUND, {"format": "pgn"}, "format: no format 'pgn'; did you mean 'png'?"),
    (SOUND, {"format": "tiled"}, "x.png: cannot be read as JSON"),
]  # fmt: skip


@pytest.mark.parametrize(("content", "options", "message"), PICTURES, ids=[str(n) for n in range(len(PICTURES))])
def test_pictures(content, options, message, tmp_path):
    assert refused(tmp_path, "x.png", content, **options).startswith(message)


def test_colours_and_tolerance_are_what_one_says(tmp_path):
    path = tmp_path / "x.png"
    path.write_bytes(rgb(b"\xfe\x01\x00" + b"\xf0\xf0\xf0" * 2 + b"\x00\xfd\x02", b"\xc0\xc0\xc0" * 4))
    document = import_map(path, tolerance=15, colours={"#C0C0C0": "wall"})
    assert (document["agents"], document["goal"], document["topology"]["without"]) == ([4], 7, [0, 1, 2, 3])


def test_nothing_is_imported_without_pillow(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "PIL", None)
    assert install_command("maps") in refused(tmp_path, "x.png", SOUND)


PLAN = ["#####", "#a.b#", "#.hg#", "#####"]


def changed(form: str = "tiles", **fields):
    """A sound map of Tiled with fields set, by dotted path."""
    value = map_files.tiled(PLAN, form)
    for path, new in fields.items():
        here = value
        *above, last = path.split("__")
        for name in above:
            here = here[int(name) if name.isdigit() else name]
        if new is ...:
            del here[last]
        else:
            here[int(last) if last.isdigit() else last] = new
    return value


def thing(**fields):
    """A map with one more object."""
    value = map_files.tiled(PLAN, "objects")
    value["layers"][1]["objects"].append({"id": 9, "name": "", "type": "box", "x": 16, "y": 32, "width": 16, "height": 16, **fields})
    return value


def zipped(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data)).decode()


TILED = [
    ([1, 2], "x.tmj: is no map of Tiled; expected a mapping whose `type` is map"),
    ({"nodes": []}, "x.tmj: is no map of Tiled; expected a mapping"),
    ({"type": "tileset"}, "x.tmj: is no map of Tiled, it is of the type 'tileset'; expected"),
    (changed(orientation="hexagonal"), "x.tmj: orientation: a map that is hexagonal, expected orthogonal"),
    (changed(infinite=True), "x.tmj: infinite: the map has no size"),
    (changed(width=...), "x.tmj: width: is missing"),
    (changed(width="5"), "x.tmj: width: got '5', expected a whole number"),
    (changed(height=0), "x.tmj: height: got 0, expected at least 1"),
    (changed(layers={}), "x.tmj: layers: got a mapping, expected a list"),
    (changed(layers__0__type="tiles"), "x.tmj: layers.0.type: got 'tiles', expected tilelayer, objectgroup, imagelayer or group"),
    (changed(width=100_000, height=100_000), "x.tmj: 100000 x 100000 squares are 10000000000, expected at most"),
    (changed(width=6), "x.tmj: layer 'all': 5 x 4 squares, expected 6 x 4 as the map has"),
    (changed(layers__0__data=[1] * 19), "x.tmj: layer 'all': data: 19 tiles, expected 20, one for each square"),
    (changed(layers__0__data=None), "x.tmj: layer 'all': data: expected a list of numbers"),
    (changed(layers__0__data__7=-1), "x.tmj: layer 'all': data.7: expected the number of a tile, 0 to 4294967295"),
    (changed(layers__0__data__7=1.5), "x.tmj: layer 'all': data.7: expected the number of a tile"),
    (changed(layers__0__data__7=9), "x.tmj: layer 'all', square 2, 1: there is no tile 9 in the 1 tileset of the map"),
    (changed(layers__0__data__7=8), "x.tmj: layer 'all', square 2, 1: tile 8 has no meaning; expected one of wall, floor, box, hole, agent, goal or ignore as the class of the tile"),
    (changed(tilesets=[]), "x.tmj: layer 'all', square 0, 0: there is no tile 1 in the 0 tilesets of the map"),
    (changed(tilesets=[{"firstgid": 1, "source": "k.tsx"}]), "x.tmj: layer 'all', square 0, 0: tile 1 has no meaning, as its tileset k.tsx is a file of its own, which is not read"),
    (changed(tilesets__0__firstgid="1"), "x.tmj: tilesets.0.firstgid: got '1', expected a whole number"),
    (changed(layers__0__data__7=6), "x.tmj: square 3, 2: a second goal, the first is at x.tmj: square 2, 1"),
    (changed(layers__0__offsetx=8), "x.tmj: layer 'all': is moved by 8, 0 pixels, expected no offset"),
    (changed("zlib", layers__0__compression="zstd"), "x.tmj: layer 'all': compression: 'zstd', expected none, zlib or gzip"),
    (changed("zlib", layers__0__encoding="csv"), "x.tmj: layer 'all': data: expected a list of numbers, or text"),
    (changed("base64", layers__0__data="&&&&"), "x.tmj: layer 'all': data: cannot be unpacked"),
    (changed("base64", layers__0__data="AAAA"), "x.tmj: layer 'all': data: 3 bytes instead of the 80 bytes of 20 squares"),
    (changed("zlib", layers__0__data="AAAA"), "x.tmj: layer 'all': data: cannot be unpacked"),
    (changed("zlib", layers__0__data=zipped(bytes(50_000_000))), "x.tmj: layer 'all': data: more than the 80 bytes of 20 squares"),
    (thing(type="chest"), "x.tmj: layer 'things', object 9: 'chest' has no meaning, expected one of wall, floor"),
    (thing(ellipse=True), "x.tmj: layer 'things', object 9: ellipse: expected a rectangle, a point or a tile"),
    (thing(rotation=45), "x.tmj: layer 'things', object 9: is turned by 45 degrees, expected 0"),
    (thing(x=800), "x.tmj: layer 'things', object 9: lies outside the map of 5 x 4 squares"),
    (thing(x=1e300), "x.tmj: layer 'things', object 9: x: 1e+300, expected a number from -1e+09"),
    (thing(width=-5), "x.tmj: layers.1.objects.4.width: got -5, expected at least 0"),
    (thing(x=0), "x.tmj: layer 'things', object 9: the box stands on a wall, expected floor"),
    (thing(x=48, y=16), "x.tmj: square 3, 1: a second box on this square, expected one"),
    (thing(x=16, y=16), "x.tmj: square 1, 1: the agent at 1,1 shares its square with a box"),
    (thing(properties=[{"name": "height", "value": "high"}]), "x.tmj: layer 'things', object 9: height: 'high', expected a number"),
    (thing(gid=77), "x.tmj: layer 'things', object 9: there is no tile 77"),
]  # fmt: skip


@pytest.mark.parametrize(("value", "message"), TILED, ids=[str(n) for n in range(len(TILED))])
def test_tiled(value, message, tmp_path):
    assert refused(tmp_path, "x.tmj", json.dumps(value).encode()).startswith(message)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "x.json: cannot be read as JSON: Expecting value: line 1 column 1"),
        (b'{"type": "map",\n "width": }', "x.json: cannot be read as JSON: Expecting value: line 2 column 11"),
        (b'{"type": "map", "width": NaN}', "x.json: cannot be read as JSON: NaN is no finite number"),
        (b"[" * 100_000, "x.json: cannot be read as JSON: is nested too deeply"),
        (b"\xff\xfe", "x.json: cannot be read as JSON"),
    ],
)
def test_json(content, message, tmp_path):
    assert refused(tmp_path, "x.json", content).startswith(message)


def test_objects_of_tiled_cover_squares_and_carry_sizes(tmp_path):
    value = map_files.tiled(["....", "....", "...."], "layers")
    value["layers"] = [
        {"type": "objectgroup", "name": "Walls", "objects": [{"id": 1, "x": 2, "y": 17, "width": 28, "height": 14}]},
        {"type": "objectgroup", "name": "x", "class": "box", "properties": [{"name": "height", "value": 0.5}],
         "objects": [{"id": 2, "x": 41, "y": 40, "width": 3, "height": 3}, {"id": 3, "gid": 0x80000001, "x": 48, "y": 48, "width": 16, "height": 16, "properties": [{"name": "Height", "value": 2}]}]},
        {"type": "objectgroup", "name": "x", "objects": [{"id": 4, "x": 0, "y": 0, "properties": [{"name": "agent", "value": True}]}, {"id": 5, "name": "Hole", "x": 40, "y": 8, "properties": [{"name": "depth", "value": 2.5}]}]},
        {"type": "group", "name": "ignore", "layers": [{"type": "objectgroup", "name": "x", "objects": [{"id": 1, "x": 900, "y": 9, "type": "chest"}]}]},
        {"type": "imagelayer", "name": "photo"},
    ]  # fmt: skip
    path = tmp_path / "x.tmj"
    path.write_text(json.dumps(value))
    document = import_map(path, goal=(3, 0))
    assert document["topology"]["without"] == [4, 5]
    assert document["boxes"] == [[2, 0.5], [3, 2.0]]
    assert document["holes"] == [{"node": 10, "depth": 2.5}]
    assert (document["agents"], document["goal"]) == ([8], 11)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["x.map", "--goal", "5"], "--goal 5: expected X,Y"),
        (["x.map", "--crop", "1,2,3"], "--crop 1,2,3: expected X0,Y0,X1,Y1"),
        (["x.map", "--agents", "1,2;3,4"], "--agents 1,2;3,4: expected X,Y"),
        (["x.map", "--agents", "0"], "agents: 0, expected a whole number from 1"),
        (["x.map", "--colours", "#ffffff"], "--colours #ffffff: expected COLOUR=KIND"),
        (["x.map", "--colours", "#ffffff=wall"], "colours: only pictures have colours, and this is read as movingai"),
        (["x.map", "--floor", "x"], "floor: 'x', expected some of the characters . G S @ O T W"),
        (["x.txt"], "x.txt: its ending does not say what map it is, expected one of .map, .xsb, .sok, .png, .tmj, .json, or a format"),
        (["no.map"], "no.map: no such file"),
        (["."], ".: its ending does not say"),
        (["x.map", "-o", "x.map"], "x.map: exists already; it is not overwritten"),
    ],
)
def test_commands(words, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("x.map").write_bytes(map_files.movingai(["....", "...."]))
    made = CliRunner().invoke(app, ["import", *words])
    assert made.exit_code == 2 and made.stderr.startswith(f"Error: {message}") and made.stderr.count("\n") == 1


def test_a_map_larger_than_a_scenario_may_be_is_refused_unless_it_is_cropped(tmp_path):
    rows = "\n".join(["." * 2000] * 1200)
    content = f"type octile\nheight 1200\nwidth 2000\nmap\n{rows}\n".encode()
    message = refused(tmp_path, "x.map", content)
    assert message == "x.map: 2000 x 1200 squares are 2400000, expected at most 2000000; crop keeps a part: x0,y0,x1,y1"
    document = import_map(tmp_path / "x.map", crop=(1990, 1195, 1999, 1199), goal=(1999, 1199), agents=[(1990, 1195)])
    assert (document["topology"], document["agents"], document["goal"]) == ({"kind": "grid", "columns": 10, "rows": 5}, [40], 9)


@pytest.mark.parametrize("side", [150, pytest.param(512, marks=pytest.mark.slow), pytest.param(1024, marks=pytest.mark.slow)])
def test_a_large_map(side, tmp_path):
    """As those of cities and games: of many parts one is kept, and the file that is written is valid."""
    rng = random.Random(4)
    rows = ["".join("T" if rng.random() < 0.3 else "." for _ in range(side)) for _ in range(side)]
    path, out = tmp_path / "big.map", tmp_path / "big.yaml"
    path.write_text("\n".join(["type octile", f"height {side}", f"width {side}", "map", *rows, ""]))
    made = CliRunner().invoke(app, ["import", str(path), "--diagonals", "--agents", "50", "-o", str(out)])
    assert made.exit_code == 0, made.output
    checked = CliRunner().invoke(app, ["validate", str(out)])
    found = re.search(r"valid: (\d+) nodes, (\d+) edges, 0 holes, 0 boxes, 50 agents", checked.stdout)
    assert found and 0.6 * side**2 < int(found[1]) < sum(row.count(".") for row in rows)


FUZZED = sorted(path.name for path in MAPS.iterdir())


def damaged(content: bytes, rng: random.Random) -> bytes:
    """A file of which some bytes are others, missing, doubled or new."""
    found = bytearray(content)
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(found) + 1)
        new = rng.choice((b"", rng.randbytes(rng.randint(1, 3)), b"9" * rng.randint(1, 12), found[at : at + rng.randint(1, 40)] * 2))
        found[at : at + rng.choice((0, 0, 1, 2, 9))] = new
        if rng.random() < 0.1:
            del found[rng.randrange(len(found) + 1) :]
    return bytes(found)


def mended(content: bytes) -> bytes:
    """A PNG whose chunks have right checksums again, so that more of it is read."""
    at, found = 8, content[:8]
    while at + 12 <= len(content):
        (length,) = struct.unpack(">I", content[at : at + 4])
        body = content[at + 4 : at + 8 + length]
        found += content[at : at + 4] + body + struct.pack(">I", zlib.crc32(body))
        at += 12 + length
    return found


JUNK = [None, True, -1, 0, 1.5, 10**30, 1e300, "", "box", "AAAA", [], {}, [0], [[]], {"name": 3}, 2**31 + 2]


def damaged_json(content: bytes, rng: random.Random) -> bytes:
    value = json.loads(content)
    for _ in range(rng.randint(1, 3)):
        here = value
        while True:
            keys = list(here) if isinstance(here, dict) else list(range(len(here)))
            if not keys:
                break
            key = rng.choice(keys)
            if isinstance(here[key], (dict, list)) and rng.random() < 0.7:
                here = here[key]
                continue
            if rng.random() < 0.2:
                del here[key]
            else:
                here[key] = copy.deepcopy(rng.choice(JUNK))
            break
    return json.dumps(value).encode()


def write_damaged(name: str, number: int, folder: Path) -> Path:
    rng = random.Random(f"{name} {number}")
    content = (MAPS / name).read_bytes()
    structured = name.endswith(".tmj") and rng.random() < 0.8
    content = damaged_json(content, rng) if structured else damaged(content, rng)
    if name.endswith(".png") and rng.random() < 0.7:
        content = mended(content)
    path = folder / f"damaged{Path(name).suffix}"
    path.write_bytes(content)
    return path


def check_damaged(name: str, number: int, folder: Path) -> bool:
    """A damaged file is imported or refused with one line, and nothing else happens; whether it was imported."""
    path = write_damaged(name, number, folder)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ColonysimWarning)
        try:
            import_map(path)
        except ColonysimError as error:
            assert str(error).isprintable(), (name, number)
            return False
    return True


@pytest.mark.parametrize("name", FUZZED)
def test_damaged_maps(name, tmp_path):
    for number in range(40):
        check_damaged(name, number, tmp_path)
    made = CliRunner().invoke(app, ["import", str(write_damaged(name, 1000, tmp_path))])
    errors = [line for line in made.stderr.splitlines() if not line.startswith("Warning: ")]
    assert made.exit_code in (0, 2) and len(errors) == (made.exit_code == 2), made.output


@pytest.mark.slow
@pytest.mark.parametrize("name", FUZZED)
def test_many_damaged_maps(name, tmp_path):
    assert 20 < sum(check_damaged(name, number, tmp_path) for number in range(1000, 4000)) < 2000
