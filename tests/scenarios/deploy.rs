//! What systemd needs: units that it accepts, and a service that tells it when it is ready, alive and stopping.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use railgrip_requirements::{DPKG_DEB, PROMTOOL, SYSTEMD_ANALYZE};
use railgrip_tests::{Process, TrainUnderTest, program, within};
use rustix::process::Signal;

railgrip_requirements::tests! {
    systemd_accepts_the_units: [SYSTEMD_ANALYZE],
    systemd_finds_the_units_hardly_exposed: [SYSTEMD_ANALYZE],
    the_command_of_the_container_starts: [],
    prometheus_accepts_rules_their_tests_and_the_config: [PROMTOOL],
    a_package_is_installed_runs_is_upgraded_and_purged: [DPKG_DEB],
    an_earlier_release_is_upgraded_with_its_config_and_state: [DPKG_DEB],
    sources_without_git_know_their_commit: [],
    a_service_says_when_it_is_ready_alive_and_stopping: [],
}

fn units() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../deploy/systemd")
}

/// Copies the units, with `edit` applied, into a folder and lets systemd read them; returns what it complains about.
fn verify(edit: impl Fn(&str) -> String) -> String {
    let folder = tempfile::tempdir().expect("folder");
    let mut files = Vec::new();
    for entry in std::fs::read_dir(units()).expect("units").flatten() {
        let name = entry.file_name().to_string_lossy().replace("@.", "@3.");
        if !name.ends_with(".service") && !name.ends_with(".target") {
            continue;
        }
        let text = std::fs::read_to_string(entry.path()).expect("unit");
        let text = text.replace("/usr/bin/railgrip", &program!().display().to_string());
        files.push(folder.path().join(name));
        std::fs::write(files.last().expect("just pushed"), edit(&text)).expect("write");
    }
    assert_eq!(files.len(), 8, "{files:?}");
    let output =
        Command::new(SYSTEMD_ANALYZE.path()).arg("verify").args(&files).output().expect("systemd-analyze");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn systemd_accepts_the_units() {
    assert_eq!(verify(str::to_owned), "");
    let broken = verify(|text| text.replace("WatchdogSec=", "WatchdogSeconds="));
    assert!(broken.contains("WatchdogSeconds"), "the check must see a wrong key: {broken}");
}

/// Exposure by systemd's own measure, 0 to 10: all that a unit may do and needs not.
fn systemd_finds_the_units_hardly_exposed() {
    let folder = tempfile::tempdir().expect("folder");
    for entry in std::fs::read_dir(units()).expect("units").flatten() {
        let name = entry.file_name().to_string_lossy().replace("@.", "@3.");
        if !name.ends_with(".service") {
            continue;
        }
        let file = folder.path().join(&name);
        std::fs::copy(entry.path(), &file).expect("copy");
        let mut analyze = Command::new(SYSTEMD_ANALYZE.path());
        let output = analyze.args(["security", "--offline=true", "--threshold=20"]).arg(&file).output();
        let output = output.expect("systemd-analyze");
        let said = String::from_utf8_lossy(&output.stdout);
        println!("{}", said.lines().last().unwrap_or_default());
        assert!(output.status.success() && said.contains("exposure level"), "{name}: {said}");
    }
}

/// What `docker run` would start, with the config of this tree in the place of that of the image.
fn the_command_of_the_container_starts() {
    let text = std::fs::read_to_string(units().join("../Dockerfile")).expect("Dockerfile");
    let line = text.lines().find_map(|line| line.strip_prefix("CMD ")).expect("a command");
    let words: Vec<String> = serde_json::from_str(line).expect("a list of words");
    let config = units().join("../../config").canonicalize().expect("config");
    let words = words.iter().map(|word| word.replace("/etc/railgrip", &config.display().to_string()));
    let folder = tempfile::Builder::new().prefix("rg").tempdir_in("/tmp").expect("folder");
    let mut up = Command::new(program!());
    up.args(words).args(["--for", "2", "--listen", "127.0.0.1:0", "--instance"]).arg(folder.path().join("i"));
    let output = up.output().expect("start");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // Beyond loopback without tokens it is refused, which is why the image does not ask for it.
    assert!(!line.contains("0.0.0.0"), "{line}");
}

fn prometheus_accepts_rules_their_tests_and_the_config() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../deploy/prometheus");
    for words in [
        &["check", "rules", "railgrip.rules.yml"][..],
        &["test", "rules", "railgrip.rules.test.yml"],
        &["check", "config", "--syntax-only", "prometheus.yml"],
    ] {
        let output =
            Command::new(PROMTOOL.path()).args(words).current_dir(&folder).output().expect("promtool");
        let said =
            [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
        println!("{said}");
        assert!(output.status.success(), "promtool {words:?}: {said}");
    }
}

/// dpkg on a root folder of the test's own; its scripts know that folder by `DPKG_ROOT`.
fn dpkg(root: &Path, words: &[&str]) {
    let mut dpkg = Command::new("dpkg");
    dpkg.arg(format!("--root={}", root.display()))
        .args(["--force-not-root", "--force-script-chrootless", "--force-depends", "--force-confold"])
        .args(["--force-bad-path", "--log=/dev/null"])
        .args(words);
    let output = dpkg.env("DEBIAN_FRONTEND", "noninteractive").output().expect("dpkg");
    let said =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
    println!("{said}");
    assert!(output.status.success(), "dpkg {words:?}: {said}");
}

/// A folder that is the root of a system without packages.
fn empty_root(folder: &Path) -> PathBuf {
    let root = folder.join("root");
    for place in ["var/lib/dpkg/info", "var/lib/dpkg/updates", "etc"] {
        std::fs::create_dir_all(root.join(place)).expect("folder");
    }
    for file in ["var/lib/dpkg/status", "var/lib/dpkg/available", "etc/passwd", "etc/group"] {
        std::fs::write(root.join(file), "").expect("file");
    }
    root
}

/// The package of the program under test.
fn package(folder: &Path) -> String {
    let script = units().join("../deb");
    let output = Command::new(script).arg(program!()).arg(folder).output().expect("deploy/deb");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

fn a_package_is_installed_runs_is_upgraded_and_purged() {
    let folder = tempfile::Builder::new().prefix("rg").tempdir_in("/tmp").expect("folder");
    let root = empty_root(folder.path());
    let package = package(folder.path());
    let size = std::fs::metadata(root.parent().expect("folder").join(&package)).expect("a package").len();
    println!("{package}: {size} bytes");
    dpkg(&root, &["--install", &package]);
    // The program runs on the config that came with it, and a unit names nothing that is not there.
    let (installed, config) = (root.join("usr/bin/railgrip"), root.join("etc/railgrip/railgrip.toml"));
    let program = std::fs::metadata(&installed).expect("a program").len();
    println!("the program: {program} bytes");
    let mut up = Command::new(&installed);
    up.args(["up", "--for", "2", "--listen", "127.0.0.1:0", "--config"]).arg(&config);
    up.arg("--instance").arg(folder.path().join("i")).current_dir(folder.path());
    let output = up.output().expect("start");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for file in [
        "usr/lib/systemd/system/railgrip-ingest.service",
        "usr/share/man/man1/railgrip-up.1.gz",
        "usr/share/bash-completion/completions/railgrip",
    ] {
        assert!(root.join(file).exists(), "{file}");
    }
    let passwd = std::fs::read_to_string(root.join("etc/passwd")).expect("users");
    assert!(
        passwd.contains("railgrip:") || Command::new("systemd-sysusers").arg("--version").output().is_err(),
        "{passwd}"
    );
    // What an operator changed survives an upgrade and a removal; a purge takes it, with what was remembered.
    let mine = std::fs::read_to_string(&config).expect("config").replace("wagons = 8", "wagons = 2");
    std::fs::write(&config, &mine).expect("config");
    dpkg(&root, &["--install", &package]);
    assert_eq!(std::fs::read_to_string(&config).expect("config"), mine);
    let state = root.join("var/lib/railgrip/history");
    std::fs::create_dir_all(&state).expect("folder");
    dpkg(&root, &["--remove", "railgrip"]);
    assert!(!installed.exists() && config.exists() && state.exists());
    dpkg(&root, &["--purge", "railgrip"]);
    assert!(!config.exists() && !state.exists());
    let left = std::fs::read_dir(root.join("etc/railgrip")).map_or(0, Iterator::count);
    assert_eq!(left, 0, "nothing is left of the config");
}

/// The package again as that of an earlier release: its number, and a config that is not the one of today.
fn earlier(folder: &Path, package: &str) -> String {
    let (tree, earlier) = (folder.join("earlier"), folder.join("earlier.deb").display().to_string());
    let dpkg_deb = |words: &[&str]| {
        let output = Command::new(DPKG_DEB.path()).args(words).output().expect("dpkg-deb");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    let place = tree.display().to_string();
    dpkg_deb(&["--raw-extract", package, &place]);
    let control = tree.join("DEBIAN/control");
    let text = std::fs::read_to_string(&control).expect("control");
    let version =
        |line: &str| if line.starts_with("Version: ") { "Version: 0.0.9".into() } else { line.to_owned() };
    let text: String = text.lines().map(|line| version(line) + "\n").collect();
    std::fs::write(&control, text).expect("control");
    let config = "schema = 1\n[train]\nname = \"train\"\nwagons = 8\nvehicle = \"vehicle.toml\"\n[source]\nkind = \"simulate\"\n";
    std::fs::write(tree.join("etc/railgrip/railgrip.toml"), config).expect("config");
    dpkg_deb(&["--root-owner-group", "--build", &place, &earlier]);
    earlier
}

/// Keys of the blocks of a history, and the version of its tables.
fn blocks(history: &rusqlite::Connection) -> (Vec<i64>, i64) {
    let mut keys = history.prepare("SELECT key FROM packed_block ORDER BY key").expect("blocks");
    let keys = keys.query_map([], |row| row.get(0)).expect("keys").collect::<Result<_, _>>().expect("keys");
    (keys, history.pragma_query_value(None, "user_version", |row| row.get(0)).expect("a version"))
}

/// A config with keys of old, a history of tables of version 2 and a snapshot of a form that is no more: all of it is kept or
/// migrated, and what cannot be read any more is said, and ends nothing.
fn an_earlier_release_is_upgraded_with_its_config_and_state() {
    let folder = tempfile::Builder::new().prefix("rg").tempdir_in("/tmp").expect("folder");
    let (root, newer) = (empty_root(folder.path()), package(folder.path()));
    dpkg(&root, &["--install", &earlier(folder.path(), &newer)]);
    let status = || std::fs::read_to_string(root.join("var/lib/dpkg/status")).expect("status");
    assert!(status().contains("Version: 0.0.9"), "{}", status());
    let (state, config) = (root.join("var/lib/railgrip"), root.join("etc/railgrip/railgrip.toml"));
    std::fs::create_dir_all(state.join("snapshots")).expect("folder");
    let mine = format!(
        "schema = 1\n[train]\nname = \"old\"\nvehicle = \"vehicle.toml\"\n[[wagon]]\nnumber = \"51 80 1\"\n[[wagon]]\n\
         number = \"51 80 2\"\n[[wagon]]\n[source]\nkind = \"simulate\"\n[history]\nflush_s = 0.2\n[instance]\n\
         snapshot_dir = \"{}\"\n[delivery.mqtt]\nhost = \"127.0.0.1\"\nport = 1\n[delivery]\nmost_waiting = 50\n",
        state.join("snapshots").display()
    );
    std::fs::write(&config, &mine).expect("config");
    let run = || {
        let mut up = Command::new(root.join("usr/bin/railgrip"));
        up.args(["up", "--for", "5", "--listen", "127.0.0.1:0", "--config"]).arg(&config);
        up.arg("--instance").arg(folder.path().join("i")).env("STATE_DIRECTORY", &state);
        let output = up.output().expect("start");
        let said =
            [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
        assert!(output.status.success(), "{said}");
        said
    };
    run();
    // State as earlier releases left it.
    let database = state.join("old/history.db");
    let before = {
        let history = rusqlite::Connection::open(&database).expect("a history");
        let to_version_2 = "DROP TABLE vehicle; DROP TABLE track_cell; PRAGMA user_version = 2";
        history.execute_batch(to_version_2).expect("tables of version 2");
        blocks(&history).0
    };
    assert!(!before.is_empty(), "something is remembered");
    let snapshot = state.join("snapshots/vehicle-51801.snapshot");
    let bytes = std::fs::read(&snapshot).expect("a snapshot");
    let line = bytes.iter().position(|byte| *byte == b'\n').expect("a first line");
    std::fs::write(&snapshot, [b"railgrip snapshot 1", &bytes[line..]].concat()).expect("written");
    std::fs::write(state.join("depot.token"), "secret").expect("written");

    dpkg(&root, &["--install", &newer]);
    assert!(!status().contains("Version: 0.0.9"), "{}", status());
    assert_eq!(std::fs::read_to_string(&config).expect("config"), mine, "the operator's config stays");
    assert!(config.with_extension("toml.dpkg-dist").exists(), "the new one lies beside it");
    let check =
        Command::new(root.join("usr/bin/railgrip")).arg("check").arg(&config).output().expect("start");
    assert!(check.status.success(), "{}", String::from_utf8_lossy(&check.stderr));
    let said = run();
    for words in ["not a snapshot of this version", "goes on from a snapshot", "deprecated"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let (after, version) = blocks(&rusqlite::Connection::open(&database).expect("a history"));
    assert!(version > 2, "the tables are those of today");
    assert!(before.iter().all(|key| after.contains(key)), "{before:?} {after:?}");
    assert_eq!(std::fs::read_to_string(state.join("depot.token")).expect("kept"), "secret");
    let documents = root.join("usr/share/doc/railgrip");
    let document = |name: &str| std::fs::read_to_string(documents.join(name)).expect("a document");
    assert!(document("ingest.md").contains("[mapping]"));
    assert!(document("config-reference.md").contains("`[mapping.NAME]`"));
}

/// The script that finds the commit, in an archive of git (where git has written it), and where somebody says it.
fn sources_without_git_know_their_commit() {
    let folder = tempfile::tempdir().expect("folder");
    let cli = Path::new(env!("CARGO_MANIFEST_DIR")).join("../services/cli");
    let run = |command: &mut Command| {
        let output = command.output().expect("start");
        assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let (repository, unpacked) = (folder.path().join("repository"), folder.path().join("unpacked"));
    let place = repository.join("services/cli");
    std::fs::create_dir_all(&place).expect("folder");
    std::fs::create_dir(&unpacked).expect("folder");
    for file in ["build.rs", "commit", ".gitattributes"] {
        std::fs::copy(cli.join(file), place.join(file)).expect(file);
    }
    let git = |words: &[&str]| {
        let who = ["-c", "user.name=t", "-c", "user.email=t@localhost", "-C"];
        run(Command::new("git").args(who).arg(&repository).args(words))
    };
    git(&["init", "--quiet"]);
    git(&["add", "--all"]);
    git(&["commit", "--quiet", "--message", "sources"]);
    let archive = folder.path().join("sources.tar");
    git(&["archive", "--output", &archive.display().to_string(), "HEAD"]);
    run(Command::new("tar").arg("-xf").arg(&archive).arg("-C").arg(&unpacked));
    let script = folder.path().join("script");
    run(Command::new("rustc").args(["--edition", "2024", "-o"]).arg(&script).arg(cli.join("build.rs")));
    let found = |sources: &Path, given: &str| {
        let mut script = Command::new(&script);
        script.current_dir(sources.join("services/cli")).env("RAILGRIP_COMMIT", given);
        let said = run(&mut script);
        let line = said.lines().find_map(|line| line.strip_prefix("cargo::rustc-env=RAILGRIP_COMMIT="));
        line.expect("a commit").to_owned()
    };
    let commit = git(&["rev-parse", "HEAD"]);
    assert_eq!(found(&repository, ""), commit[..9]);
    assert_eq!(found(&unpacked, ""), commit[..9]);
    assert_eq!(found(&unpacked, "release-7"), "release-7");
    std::fs::remove_file(unpacked.join("services/cli/commit")).expect("removed");
    assert_eq!(found(&unpacked, ""), "unknown");
}

/// A holder that talks to a systemd of ours.
struct Served {
    train: TrainUnderTest,
    child: Child,
    socket: UnixDatagram,
}

fn served() -> Served {
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/vehicle.toml");
    let config = format!(
        "schema = 1\n[train]\nname = \"notify\"\nwagons = 1\nvehicle = \"{vehicle}\"\n[source]\nkind = \"simulate\"\n"
    );
    let train = TrainUnderTest::new(program!(), &config);
    let path = train.folder().join("notify");
    let socket = UnixDatagram::bind(&path).expect("socket");
    socket.set_read_timeout(Some(Duration::from_millis(50))).expect("timeout");
    let child = train
        .command(&["hold"])
        .env("NOTIFY_SOCKET", &path)
        .env("WATCHDOG_USEC", "400000")
        .stderr(Stdio::null())
        .spawn()
        .expect("holder");
    Served { train, child, socket }
}

impl Served {
    fn says(&self, word: &str, patience: Duration) -> bool {
        let mut buffer = [0; 256];
        within(patience, || {
            let length = self.socket.recv(&mut buffer).ok()?;
            String::from_utf8_lossy(&buffer[..length]).lines().any(|line| line == word).then_some(())
        })
        .is_some()
    }
}

fn a_service_says_when_it_is_ready_alive_and_stopping() {
    let mut served = served();
    let started = Instant::now();
    assert!(served.says("READY=1", Duration::from_secs(5)), "no READY");
    println!("ready after {:.0} ms", started.elapsed().as_secs_f64() * 1e3);
    for _ in 0..5 {
        assert!(served.says("WATCHDOG=1", Duration::from_millis(400)), "the watchdog would have struck");
    }
    let pid = served.child.id().cast_signed();
    Process { pid, role: "hold".into() }.signal(Signal::TERM);
    assert!(served.says("STOPPING=1", Duration::from_secs(2)), "no STOPPING");
    let status = within(Duration::from_secs(5), || served.child.try_wait().ok().flatten()).expect("must end");
    assert!(status.success());
    assert_eq!(served.train.shared_memory(), Vec::<String>::new());
}
