"""`lichtenberg ensemble`: runs a scene in many variants, each in a process of its own, and averages their results.

The program makes the members' scenes, inspects their result files and estimates means (src/commands/ensemble.hpp).
"""
import fcntl
import json
import os
import re
import signal
import stat
import subprocess
import time
from collections import deque
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from .. import messages
from ..ensemble_report import print_summary, summarize, to_json
from ..errors import Failure, InputError
from ..files import check_output, write_whole
from ..installation import find_program
from ..interrupted import Interruption, end_with
from ..questions import Program
from . import argument

HELP = "Runs or continues a scene in many variants on all cores: means with confidence intervals"
SET = argument(
    "--set",
    "KEY=VALUE: replaces a key of the scene, as in mechanics.position_tolerance=1e-6 or electrode[0].potential=2e3; "
    "repeat it for other keys",
    "texts",
    repeated=True,
)
ARGUMENTS = [
    argument("SCENE", "scene file (.toml)", required=True),
    argument("--conductors", "numbers of conductors, as in 64,100,144: short for --vary population.count=..."),
    argument("--seeds", "number of seeds for each variant, from the scene's upward", "int", positive=True),
    argument(
        "--vary",
        "KEY=VALUE,VALUE,...: values that a key of the scene takes, as in effects.contact_discharge.contact_distance=0.4e-3,0.8e-3 or "
        "electrode[0].radius=1e-3,2e-3; repeat it for other keys: all combinations are run",
        "texts",
        repeated=True,
    ),
    SET,
    argument(
        "--out",
        "folder of the members' result files and scenes and of ensemble.json (ensemble-2.json next to that of "
        "another sweep); finished members are not run again (default: the scene's name with -ensemble)",
    ),
    argument(
        "--device",
        "device for the field solver or for grains, cpu or cuda; for grains also cuda:0,1 or cuda:all for several "
        "devices (default: field.device of the scene, cpu for grains)",
    ),
    argument("--gather", "run nothing: make the table of the finished members and name the others (status 1 if there are any)", "flag"),
    argument(
        "--jobs",
        "members that run at the same time (default: one per core, or per device of a list)",
        "int",
        positive=True,
    ),
    argument(
        "--share",
        "K/N: run the Kth of N shares of the members only, as in 3/8, so that N machines on one file system work concurrently; "
        "the same command with --gather for --share and --jobs makes the table",
        excluded="--gather",
    ),
    argument(
        "--json",
        "print JSON instead of the table, or write it to a FILE in addition to the table: the contents of ensemble.json "
        "in the folder",
        value_optional=True,
    ),
    argument("--quiet", "show no progress", "flag"),
]


@dataclass
class Member:
    """One scene of the ensemble."""

    name: str  # stem of the member's file names: "count-64_seed-1"
    settings: list  # (key, value as TOML has it, value), in the order of the variations
    text: str  # text of the scene file
    cost: float  # expected run time, in a unit of the ensemble
    sentence: str  # error message of a failed member
    number: int  # index among all members
    state: str = "waiting"  # waiting (to be run or resumed), running, finished, stopped (at a checkpoint) or failed
    quantities: dict = field(default_factory=dict)  # results of a finished member
    warnings: list = field(default_factory=list)


class Members(Program):
    """The program's process that answers requests about the members of this ensemble."""

    def __init__(self, request):
        words = [f"--out={request.out}", f"--seeds={request.seeds or 1}"]
        words += [f"--device={request.device}"] if request.device else []
        words += [f"--conductors={request.conductors}"] if request.conductors else []
        words += [f"--vary={each}" for each in request.vary] + [f"--set={each}" for each in request.set]
        super().__init__("ensemble-members", *words, "--", request.scene, own_session=True)
        about = self.read()
        self.version, self.commit, self.mark = about["version"], about["commit"], about["mark"]
        self.devices = about["devices"]  # values of --device, if members run side by side on several devices
        self.members = [Member(number=number, **self.read()) for number in range(about["members"])]
        for member in self.members:
            member.state = "failed" if member.sentence else "waiting"


class Folder:
    """The folder of the ensemble's files. Locks prevent its use by a second ensemble; of an ensemble in shares, each
    share can be run once at a time. The members' processes inherit the locks, so a folder in which one still runs
    stays locked."""

    def __init__(self, path, share):
        try:
            os.makedirs(path, exist_ok=True)
        except OSError as error:
            if isinstance(error, FileExistsError):
                raise InputError(f"--out {path}: a file of this name exists, name another folder") from None
            raise InputError(f"--out {path}: the folder cannot be made ({error.strerror})") from None
        self.path = path
        self.locks = [self.lock(".lock", fcntl.LOCK_SH if share else fcntl.LOCK_EX)]
        if share:
            self.locks.append(self.lock(f".lock-{share[0]}-of-{share[1]}", fcntl.LOCK_EX))

    def lock(self, name, kind):
        flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK
        try:
            file = os.open(os.path.join(self.path, name), flags, 0o666)
        except OSError as error:
            raise InputError(f"{self.path} cannot be written ({error.strerror})") from None
        try:
            fcntl.flock(file, kind | fcntl.LOCK_NB)
        except OSError:
            words = "wait for it, or name another folder with --out"
            raise InputError(f"another ensemble is at work in {self.path}: {words}") from None
        return file

    def file(self, member, suffix):
        return os.path.join(self.path, member.name + suffix)

    def write_scene(self, member, mark):
        """Writes the member's scene for reading it or running it alone. If the file exists and no ensemble wrote it, it stays and
        the member fails."""
        path = self.file(member, ".toml")
        if os.path.exists(path) and not first_line(path).endswith(mark):
            member.state, member.sentence = "failed", f"{path} exists and is not a scene of an ensemble"
        else:
            write_whole(path, member.text)


def first_line(path):
    """Returns the first line that is not empty."""
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return next((line.strip() for line in file if line.strip()), "")
    except OSError:
        return ""


def inspect(program, folder, member):
    """Sets the member's state from its result file: finished, waiting (to be run or resumed), or failed because the
    file belongs to another scene or is damaged. A finished member gets its quantities."""
    if os.path.exists(folder.file(member, ".h5")):
        answer = program.ask(inspect=member.number, just_ended=member.state == "finished")
        for name, value in answer.items():
            setattr(member, name, value)


class Process:
    """`lichtenberg run` in a separate process and process group. An interruption from the keyboard reaches only this
    process, which passes it on once. If this process ends, the system interrupts the run."""

    def __init__(self, folder, member, device):
        self.member, self.device, self.messages = member, device, os.memfd_create("messages")
        result = folder.file(member, ".h5")
        words = ["lichtenberg", "run", f"--out={result}", "--quiet", *[f"--device={device}"] * bool(device)]
        words += ["--resume"] * os.path.exists(result) + ["--", folder.file(member, ".toml")]
        streams = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": self.messages}
        start = partial(start_own_process_group, os.getpid())
        try:
            self.process = subprocess.Popen(
                words, executable=find_program(), pass_fds=folder.locks, preexec_fn=start, **streams
            )
        except OSError as error:
            raise Failure(f"no process can be started ({error.strerror})") from None
        member.state = "running"

    def interrupt(self):
        self.process.terminate()

    def over(self):
        """Returns true if the process has ended; then the member's state is set from its exit status."""
        status = self.process.poll()
        if status is None:
            return False
        self.member.state = {0: "finished", -15: "stopped"}.get(status, "failed")
        if self.member.state == "failed":
            ended = f"by the signal {signal.strsignal(-status)}" if status < 0 else f"with status {status}"
            self.member.sentence = self.last_message() or f"ended {ended}"
        os.close(self.messages)
        return True

    def last_message(self):
        """Returns the last error message of the program."""
        text = os.pread(self.messages, os.fstat(self.messages).st_size, 0).decode(errors="replace")
        return text.rpartition("lichtenberg: ")[2].split("\n")[0] if "lichtenberg: " in text else ""


def start_own_process_group(parent):
    os.setpgid(0, 0)
    end_with(parent)


class Progress:
    """The progress line: 12 of 48 done, 2 running, 1 failed, about 3 min 20 s left"""

    def __init__(self, members, quiet):
        self.members, self.quiet, self.terminal = members, quiet, os.isatty(2)
        self.cost_at_start = self.cost_left()
        self.began = self.shown = time.monotonic()
        self.unfinished_line = False

    def show(self):
        now = time.monotonic()
        if self.quiet or now - self.shown < (0.2 if self.terminal else 30):
            return
        self.shown, self.unfinished_line = now, self.terminal
        messages.write_error(f"\r{self.line()}\033[K" if self.terminal else self.line(), end="" if self.terminal else "\n")

    def end_line(self):
        """Ends the progress line, so that other output begins on a new line."""
        if self.unfinished_line:
            messages.write_error("")
        self.unfinished_line = False

    def cost_left(self):
        """Returns the fraction of the work that is done; a running member counts as half done."""
        share = {"waiting": 1, "running": 0.5}
        return sum(member.cost * share.get(member.state, 0) for member in self.members)

    def line(self):
        states = [member.state for member in self.members]
        text = f"{states.count('finished')} of {len(states)} done, {states.count('running')} running"
        if "failed" in states:
            text += f", {states.count('failed')} failed"
        left = self.cost_left()
        done = self.cost_at_start - left
        if done > 0.02 * self.cost_at_start:
            text += f", about {messages.duration((time.monotonic() - self.began) * left / done)} left"
        return text


def report_failure(member):
    messages.write_error(f"lichtenberg: {messages.printable(member.name)} failed: {messages.printable(member.sentence)}")


def run_members(program, folder, members, request, interruption):
    """Runs the waiting members, at most `jobs` at a time, in descending order of cost. After an interruption it
    returns early, when all processes have ended at their checkpoints."""
    waiting = deque(sorted((m for m in members if m.state == "waiting"), key=lambda member: -member.cost))
    running, told, progress = [], False, Progress(members, request.quiet)
    devices = program.devices or [request.device]
    jobs = request.jobs or len(program.devices) or os.cpu_count() or 1
    while waiting or running:
        if interruption.signal and not told:
            told = True
            progress.end_line()
            messages.write_error("stopping: the members end after their present steps; repeat the signal to stop at once")
            for process in running:
                process.interrupt()
        if interruption.signal:
            while waiting:
                waiting.popleft().state = "stopped"
        while waiting and len(running) < jobs:
            member = waiting.popleft()
            folder.write_scene(member, program.mark)
            if member.state == "failed":
                report_failure(member)
            else:
                busy = [process.device for process in running]
                running.append(Process(folder, member, min(devices, key=busy.count)))
        time.sleep(0.005)
        running = [process for process in running if not collect(program, folder, process, progress)]
        progress.show()
    progress.end_line()


def collect(program, folder, process, progress):
    """Returns true if the process has ended; then the member is inspected, and a failure is reported."""
    if not process.over():
        return False
    if process.member.state == "finished":
        inspect(program, folder, process.member)
    if process.member.state == "failed":
        progress.end_line()
        report_failure(process.member)
    return True


def share_of(written):
    """Parses "3/8" to (3, 8): the third of eight shares, which contains every eighth member. Returns None for None."""
    if written is None:
        return None
    found = re.fullmatch("([0-9]+)/([0-9]+)", written)
    if not found or not 1 <= int(found[1]) <= int(found[2]):
        raise InputError(f"--share {written}: a number from 1 on and how many shares there are, as in --share 3/8")
    return None if int(found[2]) == 1 else (int(found[1]), int(found[2]))


def holds_others(table, members):
    """Returns true if a table contains members that are not among these: it belongs to another sweep and must not be
    overwritten."""
    try:
        if not stat.S_ISREG(os.stat(table).st_mode):
            return True
        listed = [member["name"] for member in json.loads(Path(table).read_text(encoding="utf-8"))["members"]]
        return not set(listed) <= {member.name for member in members}
    except (OSError, ValueError, KeyError, TypeError):
        return True


def table_of(folder, members):
    """Returns the path of ensemble.json, or of ensemble-2.json and so on if the folder has tables of other sweeps."""
    number, table = 1, os.path.join(folder, "ensemble.json")
    while os.path.exists(table) and holds_others(table, members):
        number += 1
        table = os.path.join(folder, f"ensemble-{number}.json")
    return table


def fail_if_unfinished(members):
    """Names the members that have no finished result, at most twenty."""
    names = [messages.printable(member.name) for member in members if member.state != "finished"]
    if names:
        others = f" and {len(names) - 20} others" if len(names) > 20 else ""
        raise Failure(
            f"{len(names)} of {len(members)} members are not finished: {', '.join(names[:20])}{others}; "
            "their shares' messages say why, and the same command without --gather goes on with them"
        )


def report(program, request, members, share):
    summary = summarize(program, members)
    text = json.dumps(to_json(program, request.scene, members, summary), indent=1, ensure_ascii=False) + "\n"
    what = request.out if share else table_of(request.out, members)
    if not share:
        write_whole(what, text)
    label = "WARNING"
    for member in members:
        for warning in member.warnings:
            messages.write_error(f"{label:<15}{messages.printable(f'{member.name}: {warning}')}")
            label = ""
    if request.json == "true":
        return messages.put(text)
    if request.json:
        write_whole(request.json, text)
    holds = "holds" if share else "and the result files next to it hold"
    words = f"{what} {holds} {[m.state for m in members].count('finished')} of {len(members)} runs of {request.scene}"
    if share:
        words += f", share {share[0]} of {share[1]}: once all shares are done, the same command with --gather for --share and --jobs makes their table"
    messages.say(f"{words}\n{print_summary(summary)}", end="")


def act(request):
    request.out = request.out or Path(request.scene).stem + "-ensemble"
    if request.gather and request.jobs:
        raise InputError("--jobs does not apply with --gather, which runs nothing: leave one of them out")
    program = Members(request)
    members = program.members
    if all(member.state == "failed" for member in members):
        first = members[0]
        raise InputError(f"no member of this ensemble is possible; the first, {first.name}: {first.sentence}")
    if request.json not in (None, "true"):  # the same command may overwrite the table of its sweep
        if os.path.realpath(request.json) == os.path.realpath(request.scene):
            raise InputError(f"{request.json} is an input file and is not overwritten: name another file to write")
        check_output(request.json, not holds_others(request.json, members), otherwise="name another file", option="")
    share = share_of(request.share)
    if share:
        members = members[share[0] - 1 :: share[1]]
    folder = Folder(request.out, share)
    for member in members:
        if member.state == "failed":
            folder.write_scene(member, program.mark)  # the error message refers to a line of this file
            report_failure(member)
        else:
            inspect(program, folder, member)
            if member.state == "failed":
                report_failure(member)
    if request.gather:
        report(program, request, members, share=None)
        return fail_if_unfinished(members)
    interruption = Interruption()
    run_members(program, folder, members, request, interruption)
    report(program, request, members, share)
    if interruption.signal:
        messages.write_error("lichtenberg: stopped; the same command goes on from there")
        interruption.obey()
    failed = [member.state for member in members].count("failed")
    if failed:
        raise Failure(f"{failed} of {len(members)} members failed, for the reasons above")
