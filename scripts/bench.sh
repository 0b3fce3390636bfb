#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Measures and prints a CSV:  scripts/bench.sh NAME
#   commands   wall time and peak memory of simulate, check and adjust for 1e3, 1e4 and 1e5 points
#   stages     stages of adjust for 1e3 to 1e6 points on the block of strips
#   reading    size of observations.csv, rate and peak memory of check for 1e5 and 1e6 points
#   container  the HDF5 file against the folder, 1e6 points: stages read and write of adjust, check and convert
#              from and to each, the least of SARBLOCK_ROUNDS (2), interleaved, of check of five times as many;
#              CPU time and peak memory
#   python     a million points from numpy into the library and out of it, CPU time beside that of the adjustment
#              with one thread; SARBLOCK_POINTS, SARBLOCK_PYTHON (the folder of another build's package)
#   engines    an iteration of the reduced engine against Ceres SPARSE_SCHUR, and their memory
#   solve      stage solve with one thread, 100,000 points: straight strips, with 0.1 mm of noise in the
#              states, and an orbit; both engines, and those of SARBLOCK_OTHER (another program) beside
#   peer       adjust with both engines beside a plain program on Ceres (tests/benchmarks/plain_ceres.cc), one thread,
#              user time of whole processes and ratios; SARBLOCK_POINTS: only leberl-aircraft with so many points
#   growth     stages of adjust and exponents over points, passes, parameters, looks and threads
#   network    a two-dimensional net of 2,000 passes, 6 and 24 parameters each; last row: SARBLOCK_OTHER
#   many       hundreds to ten thousand passes of one point, and of two looks each at 200 points; SARBLOCK_OTHER
#              beside, up to 1,000 and 2,000 passes
#   largest    the net of 20,000 passes, SARBLOCK_POINTS points (11,600,000), in SARBLOCK_WORK
#   scratch    the net of 2,000 passes, SARBLOCK_POINTS points (1,960,000), without and with --scratch: CPU, anonymous and
#              mapped memory at most, whether all tables are the same; a third run in the memory control group of
#              the folder SARBLOCK_GROUP, if given, under its limit; SARBLOCK_BLOCK: a block made before
#   covariance all blocks of points and passes against ceres::Covariance
#   selection  corrections = "auto" against the model it chose, the block of 12 strips, interleaved
#   assembly   the sum of S over the points of nets of passes with one thread and with two: 4,000 passes
#              of 24 parameters, 20,000 of 6; SARBLOCK_ROUNDS times each (5)
#   fronts     factor and selected inverse of nets of 48,000 and 120,000 unknowns by one process and by
#              SARBLOCK_RANKS (2) of them, one thread each: times, memory of the largest, whether the bytes are the
#              same; SARBLOCK_ROUNDS times each (3), interleaved
#   orders     operations of the factor by minimum degree and by the better of it and METIS
#   machine    rates of memory and of the dense kernels on this machine
#   build      the program built in a fresh folder without a compiler cache: CPU and wall time,
#              compilations and the ten slowest; SARBLOCK_JOBS at a time (2)
# Needs a Release build (scripts/demo.sh makes one); assembly, covariance, engines, fronts, machine, orders and peer the
# preset bench (cmake --workflow --preset bench). SARBLOCK_PROGRAM and SARBLOCK_BENCH name other builds.
# Machines are noisy: compare rows of one run.
set -euo pipefail
cd "$(dirname "$0")/.."
program=${SARBLOCK_PROGRAM:-build/release/src/cli/sarblock}
bench=${SARBLOCK_BENCH:-build/bench/tests/benchmarks}
case "${1:-}" in
  machine) exec "$bench/machine_benchmark" ;;
  assembly)
    scene=datasets/benchmarks/network.toml
    "$bench/assembly_benchmark" $scene 100 20 400000 7 "${SARBLOCK_ROUNDS:-5}"
    "$bench/assembly_benchmark" $scene 125 80 2000000 1 "${SARBLOCK_ROUNDS:-5}"
    exit 0 ;;
  fronts)
    export OMPI_MCA_btl_vader_single_copy_mechanism=none OPENBLAS_NUM_THREADS=1
    [ "$(id -u)" != 0 ] || export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
    for size in "50 20 40000 7" "125 80 200000 1"; do
      # shellcheck disable=SC2086  # lines, segments, points and degree are four arguments
      mpirun -n "${SARBLOCK_RANKS:-2}" --oversubscribe --bind-to core "$bench/fronts_benchmark" \
        datasets/benchmarks/network.toml $size "${SARBLOCK_ROUNDS:-3}"
    done
    exit 0 ;;
  orders)
    "$bench/order_benchmark"
    for size in "50 20 40000" "125 80 200000"; do
      # shellcheck disable=SC2086  # lines, segments and points are three arguments
      "$bench/order_benchmark" datasets/benchmarks/network.toml $size
    done
    exit 0 ;;
  build)
    folder=$(mktemp -d -p "${SARBLOCK_WORK:-${TMPDIR:-/tmp}}")
    trap 'rm -rf "$folder"' EXIT
    export CCACHE_DISABLE=1
    cmake --preset release -B "$folder" -DCMAKE_CXX_COMPILER_LAUNCHER= --log-level=ERROR >&2
    python3 - "$folder" "${SARBLOCK_JOBS:-2}" <<'PY'
import os, resource, subprocess, sys, time

folder, jobs = sys.argv[1:]
begin = time.perf_counter()
subprocess.run(["ninja", "-C", folder, f"-j{jobs}", "sarblock"], check=True, stdout=sys.stderr)
wall_s = time.perf_counter() - begin
used = resource.getrusage(resource.RUSAGE_CHILDREN)
wall_of = {}
for line in open(os.path.join(folder, ".ninja_log")):
    if not line.startswith("#"):
        start_ms, end_ms, _, output, _ = line.rstrip("\n").split("\t")
        wall_of[output] = 1e-3 * (int(end_ms) - int(start_ms))
compiled = {name: s for name, s in wall_of.items() if name.endswith(".o")}
print("what,seconds")
print(f"cpu_s,{used.ru_utime + used.ru_stime:.0f}")
print(f"wall_s,{wall_s:.0f}")
print(f"compilations,{len(compiled)}")
for name, s in sorted(compiled.items(), key=lambda row: -row[1])[:10]:
    print(f"{name},{s:.1f}")
PY
    exit 0 ;;
  covariance)
    "$bench/covariance_benchmark"
    for size in "1000 10" "10000 30"; do
      for threads in 1 2; do
        # shellcheck disable=SC2086  # points and passes are two arguments
        "$bench/covariance_benchmark" datasets/benchmarks/strips.toml $size $threads
      done
    done
    exit 0 ;;
  engines)
    "$bench/engines_benchmark"
    for size in "1000 10" "10000 30" "100000 100"; do
      for threads in 1 2; do
        # shellcheck disable=SC2086  # points and passes are two arguments
        "$bench/engines_benchmark" datasets/benchmarks/strips.toml $size $threads
      done
    done
    exit 0 ;;
esac
[ -x "$program" ] || { echo "bench.sh: build first: scripts/demo.sh" >&2; exit 2; }
work=$(mktemp -d -p "${SARBLOCK_WORK:-${TMPDIR:-/tmp}}")
trap 'rm -rf "$work"' EXIT

if [ "${1:-}" = peer ]; then
  # shellcheck disable=SC2086  # several numbers of points
  python3 tests/benchmarks/peer.py "$program" "$bench/plain_ceres" "$work" ${SARBLOCK_POINTS:-}
  exit
fi

exec python3 - "$program" "$work" "${1:-}" <<'PY'
import filecmp, json, math, os, random, resource, shutil, statistics, subprocess, sys, time

program, work, name = sys.argv[1:4]


def run(*arguments):
    """Wall seconds, peak MiB and standard output of one command."""
    begin = time.perf_counter()
    with open(f"{work}/out", "w") as out:
        process = subprocess.Popen([program, *arguments], stdout=out)
        _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - begin
    if status != 0:
        sys.exit(f"bench.sh: {' '.join(arguments)} ended with status {status}")
    return wall, usage.ru_maxrss / 1024, open(f"{work}/out").read()


def strips(points):
    """Overrides of the benchmark scene: one strip a side for every 2000 points, 5 to 150."""
    count = min(150, max(5, points // 2000))
    north = 13000 + 4800 * (count - 1) + 12000
    return [f"points.count={points}", f"flight.0.count={count}", f"flight.1.count={count}",
            f"points.north_m=[13000, {north}]"]


def block(points):
    folder = f"{work}/block{points}"
    sets = [item for key in strips(points) for item in ("--set", key)]
    simulated = run("simulate", "datasets/benchmarks/strips.toml", "-o", folder, *sets)
    return folder, simulated


def stages(folder, *extra):
    out = [] if "-o" in extra else ["-o", f"{work}/result"]
    _, _, text = run("adjust", folder, *out, "--json", *extra)
    return json.loads(text)


def children_cpu_s():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def measured(folder, *extra):
    """summary.json of an adjustment and the CPU seconds of all its threads."""
    before = children_cpu_s()
    result = stages(folder, *extra)
    return result, children_cpu_s() - before


def simulated(scene, folder, *sets):
    items = [item for key in sets for item in ("--set", key)]
    return run("simulate", f"datasets/benchmarks/{scene}.toml", "-o", folder, *items)


def strip_sets(points, strips, overlap=0.6):
    """A block of strips from both sides; its area grows with the strips."""
    north = 13000 + 12000 * (1 - overlap) * (strips - 1) + 12000
    return [f"points.count={points}", f"flight.0.count={strips}", f"flight.1.count={strips}",
            f"flight.0.overlap={overlap}", f"flight.1.overlap={overlap}",
            f"points.north_m=[13000, {north}]"]


def parameters_set(degree):
    sigmas = [10, 5] + [1] * (degree - 1)
    return ["--set", f"adjust.correction.position.degree={degree}",
            "--set", f"adjust.correction.position.sigma_m=[{sigmas}, {sigmas}, {sigmas}]"]


def slope(pairs):
    """Least squares exponent of y over x."""
    logs = [(math.log(x), math.log(y)) for x, y in pairs if x > 0 and y > 0]
    if len(logs) < 2:
        return math.nan
    mx = sum(x for x, _ in logs) / len(logs)
    my = sum(y for _, y in logs) / len(logs)
    return sum((x - mx) * (y - my) for x, y in logs) / sum((x - mx) ** 2 for x, _ in logs)


def peak_mib(result):
    return max(cost["peak_mib"] for cost in result["stages"].values())


def own_mib():
    """Peak memory of adjusting a hundred points: of the program, not of the block."""
    folder = f"{work}/own"
    simulated("strips", folder, *strip_sets(100, 5))
    return peak_mib(stages(folder))


def growth_family(family, cases):
    """cases: value, scene overrides, options of adjust."""
    seen = {}
    own = own_mib()
    for value, sets, extra in cases:
        folder = f"{work}/growth"
        simulated("strips", folder, *sets)
        result, cpu = measured(folder, *extra)
        rows = {stage: cost["wall_s"] for stage, cost in result["stages"].items()}
        rows["cpu"] = cpu
        peak = peak_mib(result)
        counts = result["counts"]
        for stage, seconds in rows.items():
            print(f"{family},{value:g},{counts['points']},{counts['looks']},{counts['passes']},"
                  f"{result['iterations']},{stage},{seconds:.4f},{peak:.0f},", flush=True)
            seen.setdefault(stage, []).append((value, seconds))
        seen.setdefault("solve/iteration", []).append((value, rows["solve"] / result["iterations"]))
        seen.setdefault("peak less the program's own", []).append((value, peak - own))
        shutil.rmtree(folder)
    for stage, pairs in seen.items():
        print(f"{family},,,,,,{stage},,,{slope(pairs):.2f}", flush=True)


def network_row(folder, parameters, extra):
    result, cpu = measured(folder, *extra)
    counts, cost = result["counts"], result["stages"]
    print(f"{counts['points']},{counts['looks']},{counts['passes']},{counts['passes'] * parameters},"
          f"{result['iterations']},{result['accepted']},{cost['read']['wall_s']:.1f},"
          f"{cost['start']['wall_s']:.1f},{cost['solve']['wall_s']:.1f},"
          f"{cost['covariance']['wall_s']:.1f},{cost['write']['wall_s']:.1f},{cpu:.1f},"
          f"{peak_mib(result):.0f}", flush=True)


NETWORK_HEADER = ("points,looks,passes,unknowns,iterations,accepted,read_s,start_s,solve_s,"
                  "covariance_s,write_s,cpu_s,peak_mib")

def watched(arguments, group):
    """CPU seconds and the most MiB of anonymous memory and of mapped files, asked ten times a second; in a memory
    control group if one is given."""
    def enter():
        if group is not None:
            with open(f"{group}/cgroup.procs", "w") as processes:
                processes.write(str(os.getpid()))
    before = children_cpu_s()
    process = subprocess.Popen([program, *arguments], stdout=subprocess.DEVNULL, preexec_fn=enter)
    most = {"RssAnon": 0, "RssFile": 0}
    while process.poll() is None:
        with open(f"/proc/{process.pid}/status") as status:
            for line in status:
                name = line.split(":")[0]
                if name in most:
                    most[name] = max(most[name], int(line.split()[1]) / 1024)
        time.sleep(0.1)
    if process.returncode != 0:
        sys.exit(f"bench.sh: {' '.join(arguments)} ended with status {process.returncode}")
    return children_cpu_s() - before, most["RssAnon"], most["RssFile"]


def scratch_table(folder, group):
    os.mkdir(f"{work}/files")
    runs = [("memory", [], None), ("scratch", ["--scratch", f"{work}/files"], None)]
    if group is not None:
        runs.append(("scratch in the group", ["--scratch", f"{work}/files"], group))
    print("run,cpu_s,cpu_ratio,anonymous_mib,mapped_mib,same_tables")
    first_s = None
    for label, extra, limited in runs:
        result = f"{work}/result" if first_s is None else f"{work}/again"
        cpu_s, anonymous, mapped = watched(["adjust", folder, "-o", result, "-q", *extra], limited)
        first_s = first_s or cpu_s
        tables = [table for table in sorted(os.listdir(result)) if table.endswith(".csv")]
        same = not filecmp.cmpfiles(f"{work}/result", result, tables, shallow=False)[1]
        print(f"{label},{cpu_s:.1f},{cpu_s / first_s:.2f},{anonymous:.0f},{mapped:.0f},{same}", flush=True)


def with_noise(folder, sigma_m):
    """A copy of a block whose states carry noise in their positions."""
    noisy, draw = folder + "noisy", random.Random(7)
    shutil.copytree(folder, noisy)
    with open(f"{folder}/trajectories.csv") as rows, open(f"{noisy}/trajectories.csv", "w") as out:
        columns = next(rows).strip().split(",")
        out.write(",".join(columns) + "\n")
        for row in rows:
            cells = row.strip().split(",")
            for axis in ("x_m", "y_m", "z_m"):
                i = columns.index(axis)
                cells[i] = repr(float(cells[i]) + draw.gauss(0, sigma_m))
            out.write(",".join(cells) + "\n")
    return noisy


def solve_table(points):
    """Stage solve of both engines, and of another program's, interleaved; the least of three."""
    global program
    strips_block, _ = block(points)
    orbit = f"{work}/orbit"
    run("simulate", "datasets/scenes/earth-same-side.toml", "-o", orbit, "--set", f"points.count={points}")
    programs = [program] + [other for other in [os.environ.get("SARBLOCK_OTHER")] if other]
    print("block,program,engine,looks,iterations,solve_s,ns_per_look_and_iteration")
    for label, folder in (("strips", strips_block), ("strips 0.1 mm", with_noise(strips_block, 1e-4)),
                          ("earth-same-side", orbit)):
        least = {}
        for _ in range(3):
            for number, program in enumerate(programs):
                for engine in ("reduced", "ceres"):
                    shutil.rmtree(f"{work}/result", ignore_errors=True)
                    ended = subprocess.run([program, "adjust", folder, "-o", f"{work}/result", "--json", "--threads",
                                            "1", "--set", "covariance=none", "--set", f"engine={engine}"],
                                           stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
                    result = json.loads(ended.stdout)  # also of a solution that is not accepted
                    row = (result["stages"]["solve"]["wall_s"], result["counts"]["looks_used"], result["iterations"])
                    least[number, engine] = min(row, least.get((number, engine), row))
        for (number, engine), (wall, looks, iterations) in sorted(least.items()):
            print(f"{label},{'this' if number == 0 else 'other'},{engine},{looks},{iterations},{wall:.2f},"
                  f"{1e9 * wall / looks / max(1, iterations):.0f}", flush=True)
    program = programs[0]


if name == "growth":
    print("family,value,points,looks,passes,iterations,stage,wall_s,peak_mib,exponent")
    growth_family("points", [(n, strip_sets(n, 25), []) for n in (10000, 100000, 1000000)])
    growth_family("passes", [(2 * n, strip_sets(100000, n), []) for n in (5, 15, 50, 150)])
    growth_family("parameters", [(3 * (d + 1), strip_sets(30000, 25), parameters_set(d))
                                 for d in (1, 3, 7)])
    growth_family("looks", [(2 / (1 - o), strip_sets(30000, 25, o), []) for o in (0.0, 0.5, 0.75)])
    growth_family("threads", [(t, strip_sets(100000, 25), ["--threads", str(t)]) for t in (1, 2)])
elif name == "solve":
    solve_table(100000)
elif name == "many":
    print("passes,tie_points,program,user_s,peak_mib,rows_of_passes_covariance")
    for count, points, few in ((600, 0, 0), (600, 3, 0), (1000, 0, 0), (3000, 0, 0), (10000, 0, 0), (10000, 3, 0),
                               (1000, 0, 200), (2000, 0, 200), (4000, 0, 200), (20000, 0, 200), (100000, 0, 200)):
        folder = f"{work}/many{count}_{points}_{few}"
        subprocess.run([sys.executable, "tests/benchmarks/passes_of_one_point.py", str(count), str(points), folder,
                        str(few)], check=True)
        programs = {"this": program}
        if "SARBLOCK_OTHER" in os.environ and count <= (2000 if few else 1000):
            programs["other"] = os.environ["SARBLOCK_OTHER"]
        for label, one in programs.items():
            result = f"{work}/result"
            shutil.rmtree(result, ignore_errors=True)
            process = subprocess.Popen([one, "adjust", folder, "-o", result, "--threads", "1", "-q"])
            _, status, usage = os.wait4(process.pid, 0)
            if status != 0:
                sys.exit(f"bench.sh: {count} passes ended with status {status}")
            with open(f"{result}/passes_covariance.csv", encoding="utf-8") as table:
                rows = sum(1 for _ in table) - 1
            print(f"{count},{few or count * points},{label},{usage.ru_utime:.2f},{usage.ru_maxrss / 1024:.0f},{rows}", flush=True)
elif name == "network":
    print(NETWORK_HEADER)
    simulated("network", f"{work}/network")
    network_row(f"{work}/network", 6, [])
    network_row(f"{work}/network", 24, parameters_set(7))
    if "SARBLOCK_OTHER" in os.environ:
        program = os.environ["SARBLOCK_OTHER"]
        network_row(f"{work}/network", 24, parameters_set(7))
elif name == "largest":
    points = int(os.environ.get("SARBLOCK_POINTS", "11600000"))
    wall, peak, _ = simulated(
        "network", f"{work}/largest", f"points.count={points}", "flight.0.count=125",
        "flight.1.count=125", "flight.0.segments=80", "flight.1.segments=80",
        "points.east_m=[500, 400500]", "points.north_m=[13500, 917300]", "control.count=2000")
    print(f"# simulate: {wall:.0f} s, {peak:.0f} MiB", file=sys.stderr, flush=True)
    print(NETWORK_HEADER)
    network_row(f"{work}/largest", 6, [])
elif name == "scratch":
    folder = os.environ.get("SARBLOCK_BLOCK")
    if folder is None:
        folder = f"{work}/block"
        points = int(os.environ.get("SARBLOCK_POINTS", "1960000"))
        simulated("network", folder, f"points.count={points}", "control.count=2000")
    scratch_table(folder, os.environ.get("SARBLOCK_GROUP"))
elif name == "commands":
    print("points,looks,command,wall_s,peak_mib")
    for points in (1000, 10000, 100000):
        folder, (wall, peak, _) = block(points)
        looks = json.loads(run("check", folder, "--json")[2])["looks"]
        print(f"{points},{looks},simulate,{wall:.3f},{peak:.0f}")
        for command in ("check", "adjust"):
            extra = ["-o", f"{work}/result"] if command == "adjust" else []
            wall, peak, _ = run(command, folder, *extra)
            print(f"{points},{looks},{command},{wall:.3f},{peak:.0f}")
elif name == "stages":
    print("points,looks,passes,iterations,stage,wall_s,peak_mib")
    for points in (1000, 10000, 100000, 1000000):
        folder, _ = block(points)
        result = stages(folder)
        counts = result["counts"]
        for stage, cost in result["stages"].items():
            print(f"{points},{counts['looks']},{counts['passes']},{result['iterations']},{stage},"
                  f"{cost['wall_s']:.3f},{cost['peak_mib']:.0f}")
elif name == "reading":
    print("points,looks,observations_mb,check_wall_s,mb_per_s,peak_mib")
    for points in (100000, 1000000):
        folder, _ = block(points)
        size = os.path.getsize(f"{folder}/observations.csv") / 1e6
        wall, peak, text = run("check", folder, "--json")
        print(f"{points},{json.loads(text)['looks']},{size:.0f},{wall:.2f},{size / wall:.0f},{peak:.0f}")
elif name == "container":
    folder, _ = block(1000000)
    run("convert", folder, f"{folder}.h5")
    kinds = {"folder": ("", folder), "file": (".h5", f"{folder}.h5")}
    least, cpu, peak = {}, {}, {}

    def note(what, kind, seconds, cpu_s, mib):
        for table, value in ((least, seconds), (cpu, cpu_s), (peak, mib)):
            table[what, kind] = min(value, table.get((what, kind), value))

    def noted(what, kind, *arguments):
        before = children_cpu_s()
        wall, mib, _ = run(*arguments)
        note(what, kind, wall, children_cpu_s() - before, mib)

    rounds = int(os.environ.get("SARBLOCK_ROUNDS", "2"))
    for _ in range(rounds):
        for kind, (ending, source) in kinds.items():
            result, _ = measured(source, "-o", f"{work}/result{ending}")
            for stage in ("read", "write"):
                cost = result["stages"][stage]
                note(f"adjust: stage {stage}", kind, cost["wall_s"], math.nan, cost["peak_mib"])
    for _ in range(5 * rounds):
        for kind, (ending, source) in kinds.items():
            noted("read the block (check --dump-config)", kind, "check", source, "--dump-config")
    for _ in range(rounds):
        for what, of in (("block", folder), ("result", f"{work}/result")):
            for kind, (ending, _) in kinds.items():
                for way, a, b in (("from and to", of + ending, f"{work}/copied{ending}"),
                                  ("from", of + ending, f"{work}/copied.h5"),
                                  ("to", f"{of}.h5", f"{work}/copied{ending}")):
                    noted(f"convert a {what} {way}", kind, "convert", a, b)
                    shutil.rmtree(f"{work}/copied", ignore_errors=True)
                    if os.path.exists(f"{work}/copied.h5"):
                        os.remove(f"{work}/copied.h5")
    print("what,folder_s,file_s,ratio,folder_cpu_s,file_cpu_s,cpu_ratio,folder_mib,file_mib")
    for what, kind in least:
        if kind == "folder":
            a, b = least[what, "folder"], least[what, "file"]
            c, d = cpu[what, "folder"], cpu[what, "file"]
            print(f"{what},{a:.2f},{b:.2f},{a / b:.1f},{c:.2f},{d:.2f},{c / d:.1f},"
                  f"{peak[what, 'folder']:.0f},{peak[what, 'file']:.0f}")
elif name == "python":
    folder, _ = block(int(os.environ.get("SARBLOCK_POINTS", "1000000")))
    run("convert", folder, f"{folder}.h5")
    code = """
import sys, time
import sarblock

def seconds(work, most=3):
    least = float("inf")
    for _ in range(most):
        begin = time.process_time()
        out = work()
        least = min(least, time.process_time() - begin)
    return least, out

def out_of(result):
    points, looks = result.points, result.looks
    return (points.ids, points.position_m, points.covariance_enu_m2, points.solved, points.sigma_enu_m,
            looks.range_residual_m, looks.azimuth_residual_m, looks.point_index, looks.pass_index,
            result.corrections.value, result.corrections.sigma)

block = sarblock.read_block(sys.argv[1])
arrays = block.to_arrays()
into_s, _ = seconds(lambda: sarblock.Block.from_arrays(**arrays))
adjust_s, result = seconds(lambda: sarblock.adjust(block, threads=1), 1)
out_s, _ = seconds(lambda: out_of(sarblock.Result(result._core)))
print("what,cpu_s,percent_of_adjust")
print(f"adjust,{adjust_s:.2f},100")
for what, s in (("into the library", into_s), ("out of the library", out_s), ("both", into_s + out_s)):
    print(f"{what},{s:.3f},{100 * s / adjust_s:.2f}")
"""
    env = {**os.environ, "PYTHONPATH": os.environ.get("SARBLOCK_PYTHON", "build/release/python")}
    subprocess.run(["/usr/bin/python3", "-c", code, f"{folder}.h5"], check=True, env=env)
elif name == "selection":
    folder = f"{work}/block"
    run("simulate", "datasets/scenes/block-12-strips.toml", "-o", folder)
    text = open(f"{folder}/block.toml").read()
    begin, end = text.index("[adjust]"), text.index("[[pass]]")

    def cpu_of(adjust):
        with open(f"{folder}/block.toml", "w") as out:
            out.write(text[:begin] + "[adjust]\n" + adjust + "\n" + text[end:])
        result, cpu = measured(folder, "--threads", "1")
        return result, cpu

    chosen = cpu_of('corrections = "auto"')[0]["selection"]["model"]
    auto, final = [], []
    for _ in range(25):
        auto.append(cpu_of('corrections = "auto"')[1])
        final.append(cpu_of(chosen)[1])
    auto_s, final_s = statistics.median(auto), statistics.median(final)
    print("runs,auto_cpu_s,final_cpu_s,ratio")
    print(f"25,{auto_s:.4f},{final_s:.4f},{auto_s / final_s:.2f}")
else:
    sys.exit("bench.sh: NAME is commands, stages, reading, container, engines, solve, peer, growth, network, largest, "
             "scratch, covariance, selection, assembly, fronts, orders, machine or build")
PY
