//! What systemd needs: units that it accepts, and a service that tells it when it is ready, alive and stopping.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use railgrip_requirements::{PROMTOOL, SYSTEMD_ANALYZE};
use railgrip_tests::{Process, TrainUnderTest, program, within};
use rustix::process::Signal;

railgrip_requirements::tests! {
    systemd_accepts_the_units: [SYSTEMD_ANALYZE],
    systemd_finds_the_units_hardly_exposed: [SYSTEMD_ANALYZE],
    the_command_of_the_container_starts: [],
    prometheus_accepts_rules_their_tests_and_the_config: [PROMTOOL],
    a_package_is_installed_runs_is_upgraded_and_purged: [DPKG_DEB],
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

fn a_package_is_installed_runs_is_upgraded_and_purged() {
    let folder = tempfile::Builder::new().prefix("rg").tempdir_in("/tmp").expect("folder");
    let root = folder.path().join("root");
    for place in ["var/lib/dpkg/info", "var/lib/dpkg/updates", "etc"] {
        std::fs::create_dir_all(root.join(place)).expect("folder");
    }
    for file in ["var/lib/dpkg/status", "var/lib/dpkg/available", "etc/passwd", "etc/group"] {
        std::fs::write(root.join(file), "").expect("file");
    }
    let script = units().join("../deb");
    let output = Command::new(script).arg(program!()).arg(folder.path()).output().expect("deploy/deb");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let package = String::from_utf8_lossy(&output.stdout).trim().to_owned();
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
