//! `kill -9` over all roles and all sources: fresh figures come back by themselves, every time.
//!
//! A few kills by default; `RAILGRIP_KILLS` says how many in all:
//! `RAILGRIP_KILLS=1000 cargo test --release --workspace --test kills -- --nocapture`

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use railgrip_fieldbus::trdp::{Telegram, write};
use railgrip_requirements::MOSQUITTO;
use railgrip_tests::{Random, TrainUnderTest, program, within};
use rumqttc::{Client, MqttOptions, QoS};

railgrip_requirements::tests! {
    a_simulated_coupled_train: [],
    a_standard_input: [],
    connections: [],
    datagrams: [],
    a_broker: [MOSQUITTO],
    telegrams: [],
    frames_of_a_log: [],
}

/// Trains that are tormented.
const TRAINS: u64 = 7;
/// Kills of all trains together, unless the environment says otherwise.
const KILLS: u64 = 42;
/// A process that is killed has worked for so long, s.
const AT_WORK_S: [f64; 2] = [0.4, 1.6];
/// Fresh figures that are not there by then will never come.
const PATIENCE: Duration = Duration::from_secs(30);
const PERIOD: Duration = Duration::from_millis(10);
const WAGONS: usize = 2;
const V_M_S: f64 = 20.0;
const OMEGA_RAD_S: f64 = 45.45;
/// Where the figures show who was away; of other roles only the successor is waited for.
const SERVING: [&str; 4] = ["up", "hold", "ingest", "health"];

fn kills_each() -> u64 {
    let given = std::env::var("RAILGRIP_KILLS").ok().and_then(|text| text.parse::<u64>().ok());
    given.unwrap_or(KILLS).div_ceil(TRAINS)
}

fn config(name: &str, source: &str) -> String {
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/vehicle.toml");
    format!(
        "schema = 1\n[logging]\nlevel = \"warn\"\nformat = \"text\"\n[train]\nname = \"{name}\"\nwagons = {WAGONS}\n\
         vehicle = \"{vehicle}\"\n{source}"
    )
}

fn mapping(message: &str) -> String {
    format!(
        "[mapping]\nv_m_s = {{ from = \"{message}.V\" }}\nomega_f_rad_s = {{ from = \"{message}.N1\" }}\n\
         omega_r_rad_s = {{ from = \"{message}.N1\" }}\nf_perp_f_n = {{ from = \"{message}.P\" }}\n\
         f_perp_r_n = {{ from = \"{message}.P\" }}\n"
    )
}

fn port(datagrams: bool) -> u16 {
    let address = if datagrams {
        UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr())
    } else {
        TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr())
    };
    address.expect("a port").port()
}

/// Lines of all wagons.
fn lines(t_s: f64) -> String {
    (1..=WAGONS).fold(String::new(), |mut text, wagon| {
        let _ = writeln!(
            text,
            "{{\"wagon\":{wagon},\"t_s\":{t_s:.4},\"v_m_s\":{V_M_S},\"omega_f_rad_s\":{OMEGA_RAD_S},\
             \"omega_r_rad_s\":{OMEGA_RAD_S},\"f_perp_f_n\":0,\"f_perp_r_n\":0}}"
        );
        text
    })
}

/// Sends on a thread until it is dropped, and never minds whether anybody listens.
struct Feeder {
    over: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Feeder {
    fn start(mut send: impl FnMut(f64) + Send + 'static) -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let until = Arc::clone(&over);
        let thread = std::thread::spawn(move || {
            let began = Instant::now();
            for tick in 0.. {
                if until.load(Ordering::Relaxed) {
                    return;
                }
                let due = began + PERIOD * tick;
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
                send(f64::from(tick) * PERIOD.as_secs_f64());
            }
        });
        Self { over, thread: Some(thread) }
    }
}

impl Drop for Feeder {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// True if what is served of the last wagon was measured well after that instant.
fn fresh(train: &TrainUnderTest, since: Instant) -> Option<()> {
    let elapsed_s = since.elapsed().as_secs_f64();
    let age_s = train.http()?.json("/api/v1/wagons/2")?["age_s"].as_f64()?;
    (age_s < elapsed_s - 0.05).then_some(())
}

/// Kills whoever chance says, again and again; prints how long each role was away.
fn torment(name: &str, mut train: TrainUnderTest, input: Option<Arc<Mutex<Option<ChildStdin>>>>) {
    let start = |train: &mut TrainUnderTest| match &input {
        None => train.start(),
        Some(input) => {
            let pipe = train.start_fed();
            *input.lock().unwrap_or_else(PoisonError::into_inner) = Some(pipe);
        }
    };
    start(&mut train);
    train.wait_ready(PATIENCE);
    let mut random = Random::new(name.len() as u64);
    let mut away: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for kill in 0..kills_each() {
        let [least_s, most_s] = AT_WORK_S;
        std::thread::sleep(Duration::from_secs_f64(
            least_s + random.below(1000) as f64 * 1e-3 * (most_s - least_s),
        ));
        let processes = train.processes();
        let victim = processes[random.below(processes.len())].clone();
        let killed = Instant::now();
        if victim.role == "up" {
            train.kill_up();
            start(&mut train);
        } else {
            victim.kill();
        }
        let back = within(PATIENCE, || {
            let other =
                train.processes().into_iter().any(|one| one.role == victim.role && one.pid != victim.pid);
            let figures =
                SERVING.contains(&victim.role.as_str()) || victim.role == format!("estimator {WAGONS}");
            (other && (!figures || fresh(&train, killed).is_some())).then_some(())
        });
        assert!(back.is_some(), "{name}, kill {kill}: {victim:?}\n{:?}\n{}", train.processes(), train.log());
        let role = victim.role.split(' ').next().unwrap_or_default().to_owned();
        away.entry(role).or_default().push(killed.elapsed().as_secs_f64());
        // Whoever starts again must not hide that somebody else is stuck.
        let all = within(PATIENCE, || fresh(&train, killed));
        assert!(all.is_some(), "{name}, kill {kill}: {victim:?}\n{:?}\n{}", train.processes(), train.log());
    }
    train.wait_ready(PATIENCE);
    for (role, mut seconds) in away {
        seconds.sort_by(f64::total_cmp);
        let at = |share: f64| seconds[((seconds.len() - 1) as f64 * share).round() as usize];
        let (number, all) =
            (seconds.len(), seconds.iter().map(|value| format!("{value:.2}")).collect::<Vec<_>>());
        println!(
            "{name:<10} {role:<10} {number:>4} kills: median {:.2} s, 95 of 100 within {:.2} s, slowest {:.2} s; {}",
            at(0.5),
            at(0.95),
            at(1.0),
            all.join(" ")
        );
    }
    let _ = train.stop();
    assert_eq!(train.processes(), [], "no orphans");
    assert_eq!(train.shared_memory(), Vec::<String>::new(), "no shared memory left");
}

fn a_simulated_coupled_train() {
    let source = "coupled = true\n[source]\nkind = \"simulate\"\nscenario = \"demo\"\n";
    torment("simulate", TrainUnderTest::new(program!(), &config("sim", source)), None);
}

fn a_standard_input() {
    let input: Arc<Mutex<Option<ChildStdin>>> = Arc::default();
    let pipe = Arc::clone(&input);
    let _feeder = Feeder::start(move |t_s| {
        if let Some(pipe) = pipe.lock().unwrap_or_else(PoisonError::into_inner).as_mut() {
            let _ = pipe.write_all(lines(t_s).as_bytes());
        }
    });
    let train = TrainUnderTest::new(program!(), &config("in", "[source]\nkind = \"stdin\"\n"));
    torment("stdin", train, Some(input));
}

fn connections() {
    let address = format!("127.0.0.1:{}", port(false));
    let to = address.clone();
    let mut stream: Option<TcpStream> = None;
    let _feeder = Feeder::start(move |t_s| {
        if stream.is_none() {
            stream = TcpStream::connect(&to).ok();
        }
        if stream.as_mut().is_some_and(|stream| stream.write_all(lines(t_s).as_bytes()).is_err()) {
            stream = None;
        }
    });
    let source = format!("[source]\nkind = \"tcp\"\nlisten = \"{address}\"\n");
    torment("tcp", TrainUnderTest::new(program!(), &config("tcp", &source)), None);
}

fn datagrams() {
    let address = format!("127.0.0.1:{}", port(true));
    let to = address.clone();
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let _feeder = Feeder::start(move |t_s| {
        let _ = socket.send_to(lines(t_s).as_bytes(), &to);
    });
    let source = format!("[source]\nkind = \"udp\"\nlisten = \"{address}\"\n");
    torment("udp", TrainUnderTest::new(program!(), &config("udp", &source)), None);
}

/// Dies with its test.
struct Broker(Child);

impl Drop for Broker {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn a_broker() {
    let port = port(false);
    let mut command = Command::new(MOSQUITTO.path());
    command.args(["-p", &port.to_string()]).stdout(Stdio::null()).stderr(Stdio::null());
    let _broker = Broker(command.spawn().expect("a broker"));
    let listens = within(PATIENCE, || TcpStream::connect(("127.0.0.1", port)).ok());
    assert!(listens.is_some(), "the broker does not listen");
    let (client, mut connection) = Client::new(MqttOptions::new("sender", "127.0.0.1", port), 1000);
    std::thread::spawn(move || connection.iter().all(|event| event.is_ok()));
    let _feeder = Feeder::start(move |t_s| {
        let _ = client.try_publish("samples", QoS::AtLeastOnce, false, lines(t_s));
    });
    let source =
        format!("[source]\nkind = \"mqtt\"\nhost = \"127.0.0.1\"\nport = {port}\ntopic = \"samples\"\n");
    torment("mqtt", TrainUnderTest::new(program!(), &config("mqtt", &source)), None);
}

fn telegrams() {
    let address = format!("127.0.0.1:{}", port(true));
    let source = format!(
        "[source]\nkind = \"trdp\"\nlisten = \"{address}\"\ndatabase = \"device.xml\"\n{}",
        mapping("W{wagon}")
    );
    let train = TrainUnderTest::new(program!(), &config("trdp", &source));
    let telegrams = (1..=WAGONS).fold(String::new(), |mut text, wagon| {
        let _ = writeln!(
            text,
            "<telegram name=\"W{wagon}\" com-id=\"{}\" data-set-id=\"1001\"><pd-parameter cycle=\"10000\"/></telegram>",
            2000 + wagon
        );
        text
    });
    let description = format!(
        "<?xml version=\"1.0\"?><device host-name=\"bcu\" type=\"t\"><bus-interface-list>\
         <bus-interface network-id=\"1\" name=\"eth0\">{telegrams}</bus-interface></bus-interface-list><data-set-list>\
         <data-set name=\"axles\" id=\"1001\"><element name=\"V\" type=\"REAL32\"/><element name=\"N1\" type=\"REAL32\"/>\
         <element name=\"P\" type=\"REAL32\"/></data-set></data-set-list></device>"
    );
    std::fs::write(train.folder().join("device.xml"), description).expect("written");
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let mut sequence = 0;
    let _feeder = Feeder::start(move |_| {
        let data: Vec<u8> =
            [V_M_S, OMEGA_RAD_S, 0.0].iter().flat_map(|value| (*value as f32).to_be_bytes()).collect();
        sequence += 1;
        for wagon in 1..=WAGONS as u32 {
            let com_id = 2000 + wagon;
            let telegram =
                Telegram { sequence, com_id, etb_topo_count: 0, op_train_topo_count: 0, data: &data };
            let _ = socket.send_to(&write(&telegram), &address);
        }
    });
    torment("trdp", train, None);
}

fn frames_of_a_log() {
    let source = format!(
        "[source]\nkind = \"can\"\nfile = \"bus.log\"\ndatabase = \"train.dbc\"\nloop = true\n{}",
        mapping("W{wagon}Axles")
    );
    let train = TrainUnderTest::new(program!(), &config("can", &source));
    let mut database = "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: BCU\n".to_owned();
    let mut log = String::new();
    for wagon in 1..=WAGONS {
        let _ = writeln!(database, "\nBO_ {} W{wagon}Axles: 8 BCU", 256 + wagon);
        for (place, (name, unit)) in [("V", "m/s"), ("N1", "rad/s"), ("P", "N")].into_iter().enumerate() {
            let _ = writeln!(database, " SG_ {name} : {}|16@1+ (0.01,0) [0|600] \"{unit}\" BCU", 16 * place);
        }
    }
    let raw = |value: f64| ((value * 100.0).round() as u16).swap_bytes();
    for tick in 0..3000 {
        for wagon in 1..=WAGONS {
            let _ = writeln!(
                log,
                "({}.{:06}) can0 {:03X}#{:04X}{:04X}00000000",
                1_760_000_000 + tick / 100,
                tick % 100 * 10_000,
                256 + wagon,
                raw(V_M_S),
                raw(OMEGA_RAD_S)
            );
        }
    }
    std::fs::write(train.folder().join("train.dbc"), database).expect("written");
    std::fs::write(train.folder().join("bus.log"), log).expect("written");
    torment("can", train, None);
}
