"""What must hold after a run of the program in which something failed."""
import json
import os
import re

OWN = {".momentree", "bodies.csv", "joints.csv", "energy.csv", "events.jsonl", "final.json", "summary.json", "model.json",
       "report.html", "checkpoint", "springs.csv", "contacts.csv"}
HELPERS = {".momentree", ".momentree.new", ".momentree.reserve", ".momentree.former"}
TABLES = {"bodies.csv", "joints.csv", "energy.csv", "springs.csv", "events.jsonl"}


def read_tree(folder):
    """Files below a folder by their relative paths; an empty folder is a path that ends in a slash."""
    tree = {}
    for root, folders, files in os.walk(folder):
        place = os.path.relpath(root, folder)
        place = "" if place == "." else place + "/"
        for name in files:
            with open(os.path.join(root, name), "rb") as file:
                tree[place + name] = file.read()
        if not files and not folders and place:
            tree[place] = b""
    return tree


def below(tree, folder):
    return {path[len(folder) + 1:]: text for path, text in tree.items()
            if path.startswith(folder + "/") and path != folder + "/"}


def normal(name, text):
    """Without what no two runs have in common: how long they took."""
    if name.endswith("summary.json"):
        try:
            summary = json.loads(text)
        except ValueError:
            return text
        for key in ("wall_clock", "real_time_factor", "worst_step"):
            summary.pop(key, None)
        return json.dumps(summary).encode()
    if name.endswith("events.jsonl"):
        return re.sub(rb'"duration_ns": [^,}]*', b'"duration_ns": 0', text)
    if name.endswith("report.html"):
        text = re.sub(rb'"duration_ns": [^,}]*', b'"duration_ns": 0', text)
        return re.sub(rb'"wall_clock".*?"worst_step": [^,]*', b"", text, flags=re.S)
    if name.endswith(".momentree"):  # the order of lines is that of file creation
        return b"\n".join(sorted(text.split(b"\n")))
    return text


def same(one, other):
    return one.keys() == other.keys() and all(normal(name, one[name]) == normal(name, other[name]) for name in one)


def split(tree):
    """Momentree's files of a result folder, and those of its user."""
    listed = set(tree.get(".momentree", b"").decode(errors="replace").split("\n")) | HELPERS
    own = {name: text for name, text in tree.items() if name.split("/")[0] in listed}
    return own, {name: text for name, text in tree.items() if name not in own}


class Broken(Exception):
    pass


def require(condition, what):
    if not condition:
        raise Broken(what)


def status_of(tree):
    try:
        return json.loads(tree["summary.json"])["status"]
    except KeyError:
        return None
    except ValueError as error:
        raise Broken(f"summary.json is not JSON: {error}")


def unfinished(partial, good, killed, lasts=False):
    """The files of DIR.partial: whole, or as long as the run came; nothing claims more than is there."""
    own, _ = split(partial)
    status = status_of(own)
    if status == "done":
        besides = HELPERS | ({"checkpoint"} if killed else set())  # which is removed after the folder has its name
        require(same({n: t for n, t in own.items() if n not in besides}, {n: t for n, t in good.items() if n not in besides}),
                "DIR.partial says done, but is not whole")
    for name, text in own.items():
        if name in TABLES:
            whole = good.get(name, b"")
            mine = normal(name, text[:text.rfind(b"\n") + 1] if killed else text)
            require(normal(name, whole).startswith(mine), f"{name} is not the beginning of what it should be")
            require(killed or text == b"" or text.endswith(b"\n"), f"{name} ends within a line")
        elif name in ("final.json", "model.json"):
            try:  # a run that was stopped early ends in another state
                early = name == "final.json" and json.loads(text)["time"] < json.loads(good[name])["time"]
            except ValueError:
                early = False
            require(early or text == good.get(name), f"{name} is there, but cut or wrong")
        elif name == "report.html":
            said = re.search(rb'"summary": *\{\s*"status": "((?:[^"\\]|\\.)*)"', text)
            require(text.rstrip().endswith(b"</html>"), "report.html is cut")
            require(killed or lasts or (said and json.loads(b'"' + said[1] + b'"') == status),
                    "report.html has another status than summary.json")
        elif name not in OWN:
            require((killed or lasts) and name.split("/")[0] in HELPERS, f"{name} was left behind")
    return status


def users_files_are_there(before, after, folders):
    """Every file of the user's exactly once: where it was, or in the other of the two folders."""
    for folder in folders:
        for name, text in split(below(before, folder))[1].items():
            if name.endswith("/"):
                continue
            places = [path for path in after for f in folders if path.startswith(f + "/") and path.endswith("/" + name)]
            require([after[p] for p in places] == [text], f"the user's {folder}/{name} is lost or doubled: {places}")


def others_untouched(before, after, outputs):
    """Nothing beside the outputs came, went or changed."""
    mine = lambda path: any(path == o or path.startswith(o + "/") for o in outputs)
    require({p: t for p, t in before.items() if not mine(p)} == {p: t for p, t in after.items() if not mine(p)},
            "something beside the output came, went or changed: " +
            str({p for p in before.keys() ^ after.keys() if not mine(p)}))


def without_former(tree):
    return {name: text for name, text in tree.items() if not name.startswith(".momentree.former/")}


def run_law(before, after, good, code, said, killed=False, lasts=False, out="r"):
    """Of `run … --out OUT`. `good`: the tree after a run without a fault."""
    working = out + ".partial"
    others_untouched(before, after, {out, working} | ({os.path.dirname(out) + "/"} if killed or lasts else set()))
    users_files_are_there(before, after, (out, working))
    old, new, wanted = below(before, out), below(after, out), below(good, out)
    own_old, own_new, own_wanted = split(old)[0], split(new)[0], split(wanted)[0]
    partial, left = below(after, working), below(before, working)
    former = {name[len(".momentree.former/"):]: text for name, text in (partial | new).items()
              if name.startswith(".momentree.former/")}
    left_there = {"checkpoint"} if killed or lasts or "checkpoint: warning" in said else set()  # the next run removes it
    in_place = {n: t for n, t in own_new.items() if not n.startswith(".momentree.former/") and n not in left_there}
    replaced = same(in_place, own_wanted)
    in_working = (killed or lasts) and not new and same(split(former)[0], own_old)  # the next run restores it
    require(replaced or same(in_place, own_old) or in_working,
            "the result in DIR is neither the earlier one nor the new one: " + str(sorted(in_place)))
    if killed:
        if partial and not replaced and not partial.items() <= left.items():
            unfinished(without_former(partial), own_wanted, True)
        elif partial and replaced:
            status = status_of(partial)
            require(status is None or same(split(partial)[0], own_old), "the earlier result is cut, and says " + str(status))
        return
    kept = re.search(r"kept in (\S+)", said)
    require(kept is None or below(after, kept[1]), "it names a folder that is not there")
    if code == 0:
        require(replaced, "exit 0, but the result is not in its place")
        require(same(after, good) or "warning:" in said or lasts,  # without any memory there is none for the warning
                "exit 0 without a warning, but the folders are not as they should be")
        return
    if replaced and not same(own_old, own_wanted):
        require(kept is None and ("standard output" in said or "out of memory" in said),
                "the result is in its place, but it says otherwise")
    if same(partial, left) or (lasts and partial.items() <= left.items()):
        return
    if code == 2 and not lasts:  # a permanent failure can't be cleaned up, but it is reported
        require(same(in_place, own_old), "exit 2, but the result was replaced")
        own_left = {n for n, t in split(partial)[0].items() if n not in HELPERS}
        require(same(partial, left) or not own_left, f"exit 2, but something was written: {own_left}")
        return
    if partial and not replaced:
        return unfinished(without_former(partial), own_wanted, False, lasts)


def file_law(before, after, good, code, said, killed=False, lasts=False):
    """Of commands that write one file, `out`."""
    extra = {p for p in after if p.startswith("out") and ".partial-" in p} if killed else set()
    require(len(extra) <= 1, f"left behind: {extra}")
    others_untouched(before, {p: t for p, t in after.items() if p not in extra}, {p for p in good if p.startswith("out")})
    for path in good:
        if path.startswith("out"):
            require(after.get(path) in (before.get(path), good[path]), f"{path} is neither as it was nor whole")
            require(code != 0 or killed or after[path] == good[path], f"exit 0, but {path} is not written")


def synced_law(trace, out="r"):
    """What a power failure may do: a result in its place has all of its files on the disk, and those of its names."""
    working, dirty, names, status, published, paths = out + ".partial", set(), False, False, False, {}
    for line in trace.splitlines():
        what, one, two = line.split("\t")
        if what == "open":
            paths[one] = two
        elif what == "write" and paths.get(one, "").startswith(working + "/"):
            dirty.add(paths[one])
        elif what == "sync":
            path = paths.get(one)
            dirty.discard(path)
            names = names and path != working
            if published and path in ("", "."):
                return
        elif what in ("rename", "exchange") and one == working:
            require(status, "the result is moved before its status is written")
            require(not dirty, f"the result is moved before {dirty} are on the disk")
            require(not names, "the result is moved before its names are on the disk")
            published = True
        elif what == "rename" and two.startswith(working + "/") and not two.endswith(".former"):
            require(one not in dirty, f"{two} gets its name before it is on the disk")
            names = True
            if two.endswith("/summary.json"):
                status = not dirty - {working + "/.momentree"}
    require(False, "the result's new name never gets to the disk" if published else "there is no result")


def text_law(before, after, good, code, said, killed=False, lasts=False):
    """Of commands that only print."""
    require(before == after, "a file was changed by a command that only prints")
