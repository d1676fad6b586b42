//! Other programs publish on the channels themselves: what they need is written by the program, and every sample arrives.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use railgrip_requirements::{CXX, ICEORYX2_PYTHON};
use railgrip_tests::{TrainUnderTest, program, within};

railgrip_requirements::tests! {
    a_program_in_python_feeds_a_wagon: [ICEORYX2_PYTHON],
    the_header_for_c_is_one: [],
    the_publisher_in_cpp_fits_the_header: [CXX],
}

const PATIENCE: Duration = Duration::from_secs(30);

fn payloads(language: &str) -> Vec<u8> {
    let output = Command::new(program!()).args(["payloads", language]).output().expect("start");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

fn a_program_in_python_feeds_a_wagon() {
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/vehicle.toml");
    let config = format!(
        "schema = 1\n[train]\nname = \"external\"\nwagons = 1\nvehicle = \"{vehicle}\"\n[source]\nkind = \"external\"\n\
         [logging]\nformat = \"text\"\n"
    );
    let mut train = TrainUnderTest::new(program!(), &config);
    train.start();
    let counts = |name: &str| {
        let view = train.http()?.json("/api/v1/train")?;
        let estimator =
            view["processes"].as_array()?.iter().find(|one| one["process"] == "estimator")?.clone();
        estimator[name].as_u64()
    };
    assert!(within(PATIENCE, || counts("received")).is_some(), "{}", train.log());
    assert!(train.processes().iter().all(|process| process.role != "ingest"), "nothing to ingest");
    std::fs::write(train.folder().join("railgrip_payloads.py"), payloads("--python")).expect("write");
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../services/ingest/examples/publish.py");
    let script = train.folder().join("publish.py");
    std::fs::copy(example, &script).expect("copy");
    let package = ICEORYX2_PYTHON.path();
    let folder = package.parent().and_then(Path::parent).expect("a folder of packages");
    let mut python = Command::new("python3");
    python.arg(&script).arg(train.instance()).env("PYTHONPATH", folder).stdout(Stdio::null());
    let output = python.output().expect("start");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let all = within(PATIENCE, || counts("received").filter(|received| *received == 1000));
    assert!(all.is_some(), "received {:?}", counts("received"));
    let lost: Vec<Option<u64>> = ["missed", "rejected", "late"].map(counts).into();
    println!("1000 of 1000 samples from Python; missed, rejected, late: {lost:?}");
    assert_eq!(lost, [Some(0); 3]);
    assert!(train.stop().success());
}

/// Sizes are checked by the compiler that reads it.
fn the_header_for_c_is_one() {
    let folder = tempfile::tempdir().expect("folder");
    std::fs::write(folder.path().join("railgrip_payloads.h"), payloads("--c")).expect("write");
    std::fs::write(
        folder.path().join("use.c"),
        "#include \"railgrip_payloads.h\"\nint main(void) { railgrip_Sample s = {0}; return (int)s.wheelsets; }\n",
    )
    .expect("write");
    let mut cc = Command::new("cc");
    cc.args(["-Wall", "-Werror", "-std=c11", "-fsyntax-only", "use.c"]).current_dir(folder.path());
    let output = cc.output().expect("a C compiler, which the build needs too");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// The example against the header, and against the shape of the calls that it makes: the library itself is not there.
fn the_publisher_in_cpp_fits_the_header() {
    let folder = tempfile::tempdir().expect("folder");
    std::fs::write(folder.path().join("railgrip_payloads.h"), payloads("--c")).expect("write");
    std::fs::create_dir(folder.path().join("iox2")).expect("folder");
    std::fs::write(folder.path().join("iox2/iceoryx2.hpp"), include_str!("iceoryx2_shape.hpp"))
        .expect("write");
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../services/ingest/examples/publish.cpp");
    let text = std::fs::read_to_string(&example).expect("the example");
    let compile = |text: &str| {
        std::fs::write(folder.path().join("publish.cpp"), text).expect("write");
        let mut cxx = Command::new(CXX.path());
        cxx.args(["-Wall", "-Wextra", "-Werror", "-std=c++17", "-fsyntax-only", "-I.", "publish.cpp"]);
        cxx.current_dir(folder.path()).output()
    };
    let output = compile(&text).expect("a C++ compiler");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let wrong = compile(&text.replace("sample.v_m_s", "sample.speed")).expect("a C++ compiler");
    assert!(!wrong.status.success(), "a field that is none must not compile");
}
