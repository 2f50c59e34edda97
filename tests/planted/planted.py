#!/usr/bin/env python3
"""Faults that the suite must notice: a table of known ones, and random ones.

usage: planted.py check                       compares faults.txt with the files: each text is there once, its tests exist
       planted.py plant [NUMBER|TEST|FILE]... plants the faults of faults.txt (or those numbered, those that this test
                                              catches, those in this file): every test that a fault names must fail
       planted.py mutate [FILE|FOLDER]...     makes random faults in lines of include/ (or of these); prints the share
                                              that the tests catch, and the survivors
options: -c COMPILER  (clang++-16, clang++, $CXX or c++: the first that is there)    -j JOBS  (all cores)
         -d RESULTS   a file with a line per fault tried: a run that was stopped goes on where RESULTS ends. A fault is
                      tried again if the file that it changes has changed, or, a survivor, with another -t
         -s SEED      (1), -n COUNT (60) of mutate: which lines, and how many
         -t TESTS     (5) of mutate: how many tests a fault meets at most; 0 is no limit

A test is compiled alone, at -O0, against a copy of the tree in TMPDIR that holds the fault, and runs up to its first
failure. The checkout is only read. A test must pass without a fault: `plant` calls one that does not "unfit", and
`mutate` leaves it out. Real maps are not used. Tests of mpi/ need Open MPI and run on three ranks; without it they are
skipped.

How `mutate` chooses.
- Lines: code without comments, texts, preprocessor lines and static assertions, and no declaration of a type, template or
  alias. Each line has a hash of the seed, its file and its text. The COUNT lines with the least hashes are taken, so that
  a change elsewhere leaves the other faults as they are. The hash also chooses one of the operators that apply to the
  line.
- Operators: < and <=, > and >=, && and ||, a constant (n + 1, n - 1, 1.25 x), a negated condition, two swapped arguments
  of a call, a dropped statement.
- Tests: the files tests/PART/*.cpp that include the header, through other headers too, except page, torture and fuzz;
  those of mpi/ only for headers of mpi/ and render/ranks/, and those of poplar/ only for headers of poplar/. Points order
  them. Each word of the header that a test also says gives 1 / (number of tests that say the word), and four times as
  much if it stands within ten lines of the fault. The test with the header's name gets 8 points, each of the same part 4,
  each that names the header in an #include 2. They try the fault in this order until one fails or TESTS of them pass. A
  test whose object code the fault does not change does not count; after 4 TESTS of those, no more are tried.

What the result means. A fault is caught if a test fails, crashes or hangs, or if a static assertion fails. A fault that
does not compile for another reason counts neither way. A survivor passed all tests that it met. It is an equivalent (no
run can tell it from the original, such as a start value that is always overwritten), or a test beyond -t catches it, or
it is a hole in the suite. Close a hole by an assertion in the nearest test. "compiled into none": the tests do not use
the code at all.
"""
import collections, concurrent.futures, functools, getopt, hashlib, os, queue, re, shutil, signal, subprocess, sys, tempfile
import threading, time
from pathlib import Path

here = Path(__file__).resolve().parent
root = here.parent.parent


def fail(text):
    sys.exit(f"planted.py: {text}")


# ---- the table
class Fault:
    def __init__(self, number, name, line):
        self.number, self.name, self.line, self.sentence = number, name, line, ""
        self.tests, self.flags, self.refusal, self.places = [], [], "", []  # a place: (file, line of the table, its rows)

    def files(self):
        return [file for file, _, _ in self.places]


def read_table():
    faults, problems = [], []
    for n, row in enumerate((here / "faults.txt").read_text().split("\n"), 1):
        if row.startswith("#") or not row.strip():
            continue
        if head := re.fullmatch(r"== (\d+) ([a-z0-9_]+)", row):
            faults.append(Fault(int(head[1]), head[2], n))
            continue
        f = faults[-1] if faults else Fault(0, "", n)
        if row.startswith("caught by: "):
            f.tests = row[11:].split()
        elif row.startswith("flags: "):
            f.flags = row[7:].split()
        elif row.startswith("does not compile: "):
            f.refusal = row[18:]
        elif row.startswith("file: "):
            f.places.append((row[6:].strip(), n, []))
        elif f.places and row[0] in "-+ ":
            f.places[-1][2].append((row[0], row[2:]))
        elif faults and not f.sentence:
            f.sentence = row
        else:
            problems.append(f"faults.txt:{n}: this line is none of a fault's: {row}")
    return faults, problems


def behind(line, pattern):
    """What `line` of a file has behind `pattern`: nothing, a comment, or None where they differ."""
    line, pattern = line.strip(), pattern.strip()
    rest = line[len(pattern):]
    return rest if line.startswith(pattern) and re.fullmatch(r"| +// .*", rest) else None


def apply(fault):
    """The files that the fault changes, as {file: text}, and what does not match."""
    texts, problems = {}, []
    for file, at_line, rows in fault.places:
        lines = texts.get(file)
        if lines is None:
            lines = (root / file).read_text().split("\n") if (root / file).is_file() else []
        old = [text for sign, text in rows if sign != "+"]
        hits = [i for i in range(len(lines) - len(old) + 1)
                if old and all(behind(lines[i + k], old[k]) is not None for k in range(len(old)))]
        if len(hits) != 1:
            text = next((text for sign, text in rows if sign == "-"), old[0] if old else "nothing")
            problems.append(f"faults.txt:{at_line}: fault {fault.number} {fault.name}: its text is "
                            f"{f'{len(hits)} times' if hits else 'not'} in {file}: {text.strip()}")
            continue
        at = hits[0]
        shift = lines[at][:len(lines[at]) - len(lines[at].lstrip())]
        made, i = [], at
        for sign, text in rows:
            if sign == "+":
                made.append(shift + text)
            else:
                made += [lines[i]] if sign == " " else []
                i += 1
        if made == lines[at:i]:
            problems.append(f"faults.txt:{at_line}: fault {fault.number} {fault.name} changes nothing in {file}")
        texts[file] = lines[:at] + made + lines[i:]
    return {file: "\n".join(lines) for file, lines in texts.items()}, problems


def check():
    faults, problems = read_table()
    for f in faults:
        what = f"faults.txt:{f.line}: fault {f.number}"
        if not f.sentence or not f.tests or not f.places:
            problems.append(f"{what} lacks its sentence, \"caught by: PART/FILE\" or \"file: FILE\"")
        if sum(g.number == f.number for g in faults) > 1:
            problems.append(f"{what}: there are two faults of this number")
        for test in f.tests:
            source = root / "tests" / f"{test}.cpp"
            if not source.is_file() or "TEST_CASE" not in source.read_text():
                problems.append(f"{what} is caught by {test}, which does not exist or has no test case")
        problems += apply(f)[1]
    print("\n".join(problems + [f"{len(faults)} faults in {sum(len(f.places) for f in faults)} places"]))
    return 1 if problems else 0


# ---- which file includes which
@functools.cache
def included(file):
    """The files of the tree that `file` includes, by its own lines."""
    folders = [Path(file).parent, *map(Path, ["include", "bench", "examples", "tests/poplar/standin"])]
    names = re.findall(r'^ *# *include *[<"]([^>"]+)[>"]', (root / file).read_text(errors="replace"), re.M)
    found = [[f / name for f in folders if (root / f / name).is_file()] for name in names]
    return [os.path.normpath(places[0]) for places in found if places]


@functools.cache
def reached(file):
    seen, todo = set(), [file]
    while todo:
        new = set(included(todo.pop())) - seen
        seen |= new
        todo += new
    return seen


# ---- compiling and running a test
class Bench:
    """Copies of the tree, what all tests have in common, and how each test ends without a fault."""

    def __init__(self, compiler, jobs):
        self.compiler, self.work = compiler, Path(tempfile.mkdtemp(prefix="tilemesh_planted."))
        self.pristine, self.trees = self.work / "pristine", queue.Queue()
        for tree in [self.pristine] + [self.work / f"tree_{job}" for job in range(jobs)]:
            for part in ["include", "examples", "bench", "tests", "machines"]:
                if (root / part).is_dir():
                    shutil.copytree(root / part, tree / part)
            if tree != self.pristine:
                self.trees.put(tree)
        self.made, self.locks, self.lock, self.running, self.ended = {}, {}, threading.Lock(), set(), False
        self.env = dict(os.environ, LC_ALL="C", TILEMESH_FAST="1", TILEMESH_DATA="/nonexistent", OMPI_ALLOW_RUN_AS_ROOT="1",
                        OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_rmaps_base_oversubscribe="1",
                        OMPI_MCA_mpi_yield_when_idle="1", OMPI_MCA_hwloc_base_binding_policy="none")
        self.mpi = {"compile": [], "link": []}
        if shutil.which("mpicxx.openmpi"):
            self.mpi = {word: self.call(["mpicxx.openmpi", f"--showme:{word}"])[1].split() for word in self.mpi}

    def end(self):
        self.ended = True
        for process in list(self.running):
            try:
                os.killpg(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        shutil.rmtree(self.work, ignore_errors=True)

    def call(self, command, seconds=1800, cwd=None):
        """The exit status (None: it takes longer) and the output."""
        process = subprocess.Popen([str(word) for word in command], cwd=cwd, env=self.env, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
        self.running.add(process)
        try:
            out, status = process.communicate(timeout=seconds)[0], process.returncode
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            out, status = process.communicate()[0], None
        self.running.discard(process)
        if self.ended:
            raise SystemExit  # what was killed says nothing of a fault
        return status, out.decode(errors="replace")

    def once(self, make, *key):
        """make(*key), called once."""
        with self.lock:
            lock = self.locks.setdefault((make, key), threading.Lock())
        with lock:
            if (make, key) not in self.made:
                self.made[make, key] = make(*key)
            return self.made[make, key]

    def kit(self, *flags):
        """A compiler that can link these flags, precompiled headers, and doctest's main; None where there is none."""
        kit = self.work / ("kit" + re.sub(r"\W+", "_", "".join(flags)))
        kit.mkdir()
        (kit / "empty.cpp").write_text("int main() {}\n")
        headers = """algorithm array atomic chrono cmath filesystem fstream functional iostream map memory mutex numeric optional
            random span sstream string thread tuple vector doctest/doctest.h"""
        (kit / "common.hpp").write_text("".join(f"#include <{name}>\n" for name in headers.split()))
        for compiler in [self.compiler, os.environ.get("CXX", "c++"), "g++"]:
            link = [compiler, "-pthread", *flags, kit / "empty.cpp", "-o", kit / "empty"]
            if shutil.which(compiler) and self.call(link)[0] == 0:
                command = [compiler, "-std=c++20", "-O0", "-pthread", "-UNDEBUG", "-w", *flags]
                for rest in [["-x", "c++-header", kit / "common.hpp", "-o", kit / "common.hpp.gch"],
                             ["-c", self.pristine / "tests/main.cpp", "-o", kit / "main.o"]]:
                    status, log = self.call(command + rest)
                    if status != 0:
                        fail(f"{compiler} cannot compile doctest (is it installed?); {log[:300]}")
                return command, kit
        return None

    def compile(self, test, tree, flags, *rest):
        command, kit = self.once(self.kit, *flags)
        front = ["-DOMPI_SKIP_MPICXX", *self.mpi["compile"]] if test.startswith("mpi/") else []
        # The suite compiles the renderers of splat/runner.hpp apart. Here a file has their definition in front of it.
        runner = tree / "tests/splat/shared/runner_of.hpp"
        if runner.is_file() and re.search(r"(make_runner|fit_shared)<", (tree / f"tests/{test}.cpp").read_text()):
            front += ["-include", runner]
        folders = [f"-I{tree / name}" for name in ["include", "bench", "examples", "tests/poplar/standin"]]
        return self.call([*command, f"-ffile-prefix-map={tree}={self.pristine}", "-include", kit / "common.hpp", *front,
                          *folders, tree / f"tests/{test}.cpp", *rest])

    def beside(self, test, flags):
        """An object without a fault."""
        out = self.work / (re.sub(r"\W+", "_", test + "".join(flags)) + ".o")
        return out, self.compile(test, self.pristine, flags, "-c", "-o", out)[1]

    def build(self, test, tree, flags, changed, out, control=""):
        """Builds a test, and what its part links beside it (sources without a test case). Returns the compiler's error, or
        None, and a digest of the objects. Does not link objects whose digest is `control`."""
        objects, digest, part = [], hashlib.sha1(), test.split("/")[0]
        beside = [s for s in sorted((root / "tests" / part).glob("*.cpp")) if "TEST_CASE" not in s.read_text()]
        for source in [test] + [f"{part}/{s.stem}" for s in beside]:
            if source != test and not reached(f"tests/{source}.cpp") & set(changed):
                made, log = self.once(self.beside, source, flags)
            else:
                made = Path(f"{out}.{len(objects)}.o")
                log = self.compile(source, tree, flags, "-c", "-o", made)[1]
            if not made.is_file():
                return log or "the compiler takes too long", ""
            objects.append(made)
            digest.update(made.read_bytes())
        if digest.hexdigest() == control:
            return None, control
        command, kit = self.once(self.kit, *flags)
        status, log = self.call([*command, *objects, *(self.mpi["link"] if part == "mpi" else [kit / "main.o"]), "-o", out])
        return None if status == 0 else log, digest.hexdigest()

    def run(self, test, out, seconds):
        front = ["mpirun.openmpi", "-n", "3"] if test.startswith("mpi/") else []
        return self.call([*front, out, "-aa=1", "-tce=slow:*", "--no-colors=true"], seconds, out.parent)

    def control(self, test, flags, refusal):
        """How a test ends without a fault: what is wrong, whether that is only for want of a tool, seconds, digest."""
        if not self.once(self.kit, *flags) or (test.startswith("mpi/") and not self.mpi["link"]):
            return "skipped: no compiler links its flags, or Open MPI is not here", True, 0, ""
        if refusal:
            status, log = self.compile(test, self.pristine, flags, "-fsyntax-only")
            return (None if status == 0 else log[:1000]), False, 0, ""
        folder = Path(tempfile.mkdtemp(dir=self.work))
        wrong, digest = self.build(test, self.pristine, flags, [], folder / "test")
        begin = time.time()
        if not wrong:
            status, log = self.run(test, folder / "test", 1200)
            if status != 0 or not re.search(r"test cases: *[1-9]", log):
                wrong = log[-1000:] or f"status {status}"
        shutil.rmtree(folder)
        return wrong, False, time.time() - begin, digest

    def meet(self, test, tree, flags, refusal, changed):
        """What a test says of the fault in `tree`: (caught | survives | unbuilt | skipped | unfit, a reason)."""
        wrong, tool, seconds, digest = self.once(self.control, test, flags, refusal)
        if wrong:
            return ("skipped" if tool else "unfit"), f"{test} {wrong if tool else 'fails without a fault: ' + wrong}"
        if refusal:
            status, log = self.compile(test, tree, flags, "-fsyntax-only")
            caught = status != 0 and refusal in log
            return ("caught", f"{test} (does not compile: {refusal})") if caught else ("survives", test)
        folder = Path(tempfile.mkdtemp(dir=self.work))
        try:
            wrong, now = self.build(test, tree, flags, changed, folder / "test", digest)
            if wrong:
                error = next((line for line in wrong.split("\n") if "error:" in line), wrong[:200]).split("error: ")[-1]
                caught = re.search("static.assert", error)
                return ("caught" if caught else "unbuilt"), f"{test} ({error[:120]})"
            if now == digest:
                return "same", test
            status, log = self.run(test, folder / "test", 20 + 10 * seconds)
            if status == 0:
                return "survives", test
            case = re.search(r"^TEST CASE: *(.*)", log, re.M)
            case = f'"{case[1]}"' if case else f"status {status}"
            return "caught", f"{test} ({'hangs' if status is None else case})"
        finally:
            shutil.rmtree(folder)


# ---- all faults
def key_of(*texts):
    return hashlib.sha1("\0".join(texts).encode()).hexdigest()[:16]


def test_texts(tests):
    return [(root / f"tests/{test}.cpp").read_text() for test in tests]


def try_all(o, jobs):
    """A job: key, title, attempt(bench, tree) -> (word, reason), the files that it changes: {file: text}. Returns a list
    of (word, "title: reason")."""
    results, before = {}, {}
    if o["-d"] and Path(o["-d"]).is_file():
        rows = [row.split("\t") for row in Path(o["-d"]).read_text().splitlines()]
        before = {row[0]: row[2:] for row in rows if len(row) == 4 and (row[2] == "caught" or row[1] == o["-t"])}
    left = [job for job in jobs if job[0] not in before]
    print(f"{len(jobs)} faults, {len(jobs) - len(left)} of them tried before", flush=True)
    if not left:
        return [before[job[0]] for job in jobs]
    bench = Bench(o["-c"], int(o["-j"]))

    def try_one(job):
        key, title, attempt, files = job
        tree, begin = bench.trees.get(), time.time()
        for file, text in files.items():
            (tree / file).write_text(text)
        word, reason = attempt(bench, tree)
        for file in files:
            shutil.copy(bench.pristine / file, tree / file)
        bench.trees.put(tree)
        text = f"{title}: {reason}".replace("\n", " ").replace("\t", " ")
        print(f"{word}: {text} in {time.time() - begin:.0f} s", flush=True)
        if o["-d"] and word not in ["unfit", "skipped"]:
            with open(o["-d"], "a") as file:
                file.write(f"{key}\t{o['-t']}\t{word}\t{text}\n")
        return word, text

    signal.signal(signal.SIGTERM, lambda *_: sys.exit(130))
    pool = concurrent.futures.ThreadPoolExecutor(int(o["-j"]))
    try:
        results = dict(zip([job[0] for job in left], pool.map(try_one, left)))
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        bench.end()
    return [results.get(job[0]) or before[job[0]] for job in jobs]


def plant(o, wanted):
    faults, _ = read_table()
    jobs = []
    for f in faults:
        if wanted and not {str(f.number), *f.tests, *f.files()} & set(wanted):
            continue
        files, problems = apply(f)
        if problems:
            fail(problems[0])

        def attempt(bench, tree, f=f, files=files):
            said = []
            for test in f.tests:
                word, reason = bench.meet(test, tree, tuple(f.flags), f.refusal, list(files))
                said.append(reason)
                if word != "caught":
                    return word, reason
            return "caught", ", ".join(said)

        jobs.append((key_of(str(f.number), *files.values(), *test_texts(f.tests)), f"{f.number} {f.name}", attempt, files))
    if not jobs:
        fail(f"no fault is {' '.join(wanted)}; faults.txt lists them")
    count = collections.Counter(word for word, _ in try_all(o, jobs))
    print(f"{count['caught']} of {len(jobs)} caught" + (f", {count['skipped']} skipped" if count["skipped"] else ""))
    return 0 if count["caught"] + count["skipped"] == len(jobs) else 1


# ---- random faults
def blank(text):
    return re.sub(r"[^\n]", " ", text)


def balanced(code, at):
    """The place of the bracket that closes the one at `at`, or -1."""
    depth = 0
    for i in range(at, len(code)):
        depth += (code[i] in "([{") - (code[i] in ")]}")
        if depth == 0:
            return i
    return -1


def code_of(text):
    """The text with blanks in place of comments, texts, preprocessor lines and static assertions."""
    other = r'''R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])'|//[^\n]*|/\*.*?\*/|^ *#(?:[^\n]*\\\n)*[^\n]*'''
    code = re.sub(other, lambda m: blank(m[0]), text, flags=re.S | re.M)
    for m in re.finditer(r"static_assert\(", code):
        end = balanced(code, m.end() - 1)
        code = code[:m.start()] + blank(code[m.start():end + 1]) + code[end + 1:]
    return code


no_code = re.compile(r"\s*(template|using|typedef|namespace|friend|struct|class|enum|union|concept|requires|public|private|"
                     r"protected|case|default|extern|\[\[)\b|.*= (default|delete);")
plain_declaration = re.compile(r"\s*(?!.*constexpr)[\w:<>, ]+ \w+( = [\w.]+|\{[\w.]*\})(, \w+ = [\w.]+)*;")
statement = re.compile(r"\s*(?!return|throw|else|do\b|delete|goto)((if|for) \(.*\) [^;{}]*;|(break|continue);|"
                       r"(\+\+|--)[\w.\->\[\]]+;|[a-z_][\w:.\->\[\]]*(\(.*\)|\+\+|--);|"
                       r"[a-z_*][\w:.\->]*(\[.*?\]|\(.*?\)|[\w:.\->])* ?([-+*/%&|^]|<<|>>)?= .*;)$")


def operators(code, line, before, after):
    """{operator: [a line with the fault]}. `code` is the line without texts; before, after: the code around it."""
    out = collections.defaultdict(list)

    def put(name, begin, end, text):
        out[name].append(line[:begin] + text + line[end:])

    for m in re.finditer(r" (<=|>=|<|>|&&|\|\|) ", code):
        to = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "&&": "||", "||": "&&"}[m[1]]
        put(f"{m[1]} to {to}", m.start(1), m.end(1), to)
    for m in re.finditer(r"(?<![\w.<'])(?:(\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+)f?|(\d+)u?)(?![\w.>'])", code):
        if plain_declaration.fullmatch(code):
            continue
        if m[1]:
            put("constant x 1.25", m.start(1), m.end(1), repr(float(m[1]) * 1.25 or 1.0))
        else:
            put("constant + 1", m.start(2), m.end(2), str(int(m[2]) + 1))
            if int(m[2]) > 0:
                put("constant - 1", m.start(2), m.end(2), str(int(m[2]) - 1))
    if m := re.match(r"(?:\s*|.*\belse )(?:if|while)(?: constexpr)? \(", code):
        end = balanced(code, m.end() - 1)
        begin = max(m.end(), code.rfind(";", m.end(), end) + 1)
        if end > 0 and " = " not in code[begin:end] and " = " not in code[m.end():begin]:
            put("negated condition", begin, end, f"!({line[begin:end].strip()})")
    whole = all(code.count(a) == code.count(b) for a, b in ["()", "[]", "{}"])
    alone = before.rstrip()[-1:] in ";{}):" and not after.lstrip().startswith("else")
    if whole and alone and statement.fullmatch(code):
        put("dropped statement", len(code) - len(code.lstrip()), len(line), ";")
    no_call = "if|for|while|switch|sizeof|min|max|catch|decltype|noexcept|alignas"
    for m in re.finditer(rf"(\w+ )?\b(?!{no_call})([a-zA-Z_]\w*)\(", code):
        end = balanced(code, m.end() - 1)
        if end < 0 or m[1] not in [None, "return ", "else ", "const "]:
            continue
        ends, depth = [m.end() - 1], 0
        for i in range(m.end(), end + 1):
            depth += (code[i] in "([{") - (code[i] in ")]}")
            if i == end or (code[i] == "," and depth == 0):
                ends.append(i)
        spans = [(a + 1, b) for a, b in zip(ends, ends[1:])]
        if any(re.search(r"[\w>&*] +\w+$|<\w|^\s*$", code[a:b].rstrip()) for a, b in spans):
            continue
        for (a, b), (c, d) in zip(spans, spans[1:]):
            if line[a:b].strip() != line[c:d].strip():
                put("swapped arguments", a, d, f"{line[c:d].strip() if a == m.end() else line[c:d]}, {line[a:b].strip()}")
    return out


def words_of(text):
    return set(re.findall(r"[A-Za-z_]\w{3,}", text))


def mutate(o, wanted):
    tests = {}
    for source in sorted(root.glob("tests/*/*.cpp")):
        if source.parent.name not in ["page", "torture", "fuzz", "checks"] and "TEST_CASE" in source.read_text():
            tests[f"{source.parent.name}/{source.stem}"] = words_of(source.read_text())
    said_by = collections.Counter(word for words in tests.values() for word in words)

    own = {"mpi": {"mpi", "ranks"}, "poplar": {"poplar"}}  # expensive, and the same code as on one host

    def nearest(file, around, text):
        stem, folders, points = re.sub("_code$", "", Path(file).stem), Path(file).parts, {}
        for test, words in tests.items():
            source = f"tests/{test}.cpp"
            part = test.split("/")[0]
            if file in reached(source) and (part not in own or own[part] & set(folders)):
                near = words_of(around) & words
                points[test] = sum(1 / said_by[w] for w in words_of(text) & words) + 3 * sum(1 / said_by[w] for w in near)
                points[test] += 8 * (stem == test.split("/")[1]) + 4 * (test.split("/")[0] in folders)
                points[test] += 2 * any(Path(name).stem == stem for name in included(source))
        order = sorted(points, key=lambda test: (-points[test], test))
        return order

    lines = []
    for path in sorted(root.glob("include/**/*.hpp")):
        file = str(path.relative_to(root))
        if wanted and not any(file == w.rstrip("/") or file.startswith(w.rstrip("/") + "/") for w in wanted):
            continue
        text = path.read_text()
        rows, codes, times = text.split("\n"), code_of(text).split("\n"), collections.Counter()
        for i, code in enumerate(codes):
            if not code.strip() or '"' in rows[i] or no_code.match(code):
                continue
            code, before, after = code.rstrip(), "\n".join(codes[max(0, i - 20):i]), "\n".join(codes[i + 1:i + 2])
            found = operators(code, rows[i][:len(code)], before, after)
            times[rows[i]] += 1
            if found:
                chance = hashlib.sha256(f"{o['-s']}:{file}:{rows[i].strip()}:{times[rows[i]]}".encode()).digest()
                lines.append((chance, file, i, rows, found))
    lines.sort(key=lambda one: one[0])
    jobs, most = [], int(o["-t"])
    for chance, file, i, rows, found in lines[:int(o["-n"])]:
        name = sorted(found)[chance[0] % len(found)]
        new = found[name][chance[1] % len(found[name])]
        text = "\n".join(rows[:i] + [new] + rows[i + 1:])
        chosen = nearest(file, "\n".join(rows[max(0, i - 10):i + 11]), "\n".join(rows))

        def attempt(bench, tree, chosen=chosen, file=file):
            said = collections.defaultdict(list)
            for test in chosen:
                word, reason = bench.meet(test, tree, (), "", [file])
                if word in ["caught", "unbuilt"]:
                    return word, reason
                said[word].append(test)
                if most and (len(said["survives"]) == most or len(said["same"]) == 4 * most):
                    break
            if chosen and not said["survives"] + said["same"]:
                return "skipped", f"no test of {' '.join(chosen)} passes without it"
            return "survives", " ".join(said["survives"]) or "compiled into none of " + " ".join(said["same"])

        title = f"{file}:{i + 1}: {name}: {rows[i].strip()}  =>  {new.strip()}"
        jobs.append((key_of(text, title), title, attempt, {file: text}))
    if not jobs:
        fail(f"no line of {' '.join(wanted)} can hold a fault; name headers or folders below include/")
    print(f"{len(lines)} lines can hold a fault; seed {o['-s']}")
    results = try_all(o, jobs)
    count = collections.Counter(word for word, _ in results)
    survivors = sorted(text for word, text in results if word == "survives")
    by_compiler = sum("static assert" in text or "static_assert" in text for word, text in results if word == "caught")
    counted = count["caught"] + len(survivors)
    print("\nsurvivors:" if survivors else "\nno survivor", *survivors, sep="\n")
    share = 100 * count["caught"] / max(counted, 1)
    print(f"\ncaught {count['caught']} of {counted} ({share:.0f} %), {by_compiler} of them by a static assertion; "
          f"{count['unbuilt']} more do not compile")
    return 0


def main():
    try:
        given, words = getopt.gnu_getopt(sys.argv[1:], "c:j:d:s:n:t:h")
    except getopt.GetoptError as problem:
        fail(f"{problem}; see the first lines of the script")
    o = {"-c": "", "-j": str(os.cpu_count()), "-d": "", "-s": "1", "-n": "60", "-t": "5", **dict(given)}
    modes = {"check": lambda *_: check(), "plant": plant, "mutate": mutate}
    if "-h" in o or not words or words[0] not in modes or not all(o[k].isdigit() for k in ["-j", "-s", "-n", "-t"]):
        print(__doc__.split("\n\n")[1])
        sys.exit(0 if "-h" in o else 2)
    candidates = [o["-c"]] if o["-c"] else ["clang++-16", "clang++", os.environ.get("CXX", "c++"), "c++"]
    o["-c"] = next((name for name in candidates if shutil.which(name)), "")
    if not o["-c"] and words[0] != "check":
        fail(f"there is no compiler {candidates[0]} (it is not in PATH); name one with -c")
    return modes[words[0]](o, words[1:])


if __name__ == "__main__":
    sys.exit(main())
