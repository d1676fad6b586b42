//! Messages of a train become rows of its wagons: by their names on one bus, or by the bus that they come from.

use railgrip_fieldbus::{Catalogue, Gathering, Lanes, Plan, Taken, dbc};
use railgrip_recording::{Combine, Flag, Mapping, Row, Rule};

const AXLES: &str =
    " SG_ N1 : 0|16@1+ (0.01,0) [0|600] \"rad/s\" X\n SG_ N2 : 16|16@1+ (0.01,0) [0|600] \"rad/s\" X\n";
const BRAKES: &str = " SG_ P : 0|16@1+ (0.001,0) [0|12] \"bar\" X\n SG_ Ok : 16|1@1+ (1,0) [0|0] \"\" X\n";

/// A bus with wheel speeds and brakes of so many wagons, and one train speed.
fn bus(names: &[&str]) -> Catalogue {
    let mut text = "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: X\n\n".to_owned();
    for (place, name) in names.iter().enumerate() {
        text += &format!(
            "BO_ {} {name}Axles: 4 X\n{AXLES}\nBO_ {} {name}Brakes: 3 X\n{BRAKES}\n",
            256 + place,
            512 + place
        );
    }
    text += "BO_ 80 Train: 2 X\n SG_ V : 0|16@1+ (0.01,0) [0|655] \"km/h\" X\n";
    dbc::read(&text).expect("a DBC file")
}

fn rule(to: &str, from: &str, factor: f64) -> Rule {
    Rule { to: to.into(), from: vec![from.into()], combine: Combine::First, factor, offset: 0.0, flag: None }
}

fn mapping(prefix: &str) -> Mapping {
    let flag = Some(Flag { from: format!("{prefix}Brakes.Ok"), is: 1.0 });
    let force = |to: &str| Rule { flag: flag.clone(), ..rule(to, &format!("{prefix}Brakes.P"), 16_000.0) };
    let rules = vec![
        rule("v_m_s", "Train.V", 1.0 / 3.6),
        rule("omega_f_rad_s", &format!("{prefix}Axles.N1"), 1.0),
        rule("omega_r_rad_s", &format!("{prefix}Axles.N2"), 1.0),
        force("f_perp_f_n"),
        force("f_perp_r_n"),
    ];
    Mapping { rules }
}

/// Rows of the messages `(lane, key, data, time)`, and what became of the last one.
fn rows(plan: &Plan, messages: &[(usize, u32, &[u8], f64)]) -> (Vec<(usize, Row)>, Taken) {
    let mut gathering = Gathering::new(plan.clone(), 0.5);
    let (mut rows, mut last) = (Vec::new(), Taken::default());
    for (lane, key, data, at_s) in messages {
        last = gathering.take(*lane, *key, data, *at_s, &mut |wagon, row| rows.push((wagon, row)));
    }
    (rows, last)
}

#[test]
fn one_mapping_serves_all_wagons_of_one_bus_by_their_numbers() {
    let plan = Plan::new(&bus(&["W01", "W02"]), &mapping("W{wagon:02}"), &[2, 2], Lanes::Shared, None)
        .expect("a plan");
    assert_eq!(plan.keys(), [80, 256, 257, 512, 513]);
    let (axles, brakes) = ([0x10, 0x27, 0x20, 0x4e], [0xb8, 0x0b, 1]);
    let messages: &[(usize, u32, &[u8], f64)] =
        &[(0, 80, &[0x20, 0x1c], 0.0), (0, 513, &brakes, 0.1), (0, 257, &axles, 0.2), (0, 256, &axles, 0.3)];
    let (rows, last) = rows(&plan, messages);
    assert_eq!(rows.iter().map(|(wagon, _)| *wagon).collect::<Vec<_>>(), [1, 0]);
    let second = rows[0].1;
    assert!((second.v_m_s - 20.0).abs() < 1e-12 && (second.pressing_force_n[1] - 48_000.0).abs() < 1e-6);
    assert_eq!((second.t_s, second.wheel_speed_rad_s[0], second.wheel_speed_rad_s[1]), (0.2, 100.0, 200.0));
    assert!(rows[1].1.pressing_force_n[0].is_nan(), "no brake of wagon 1 was heard of");
    assert_eq!(last, Taken { wanted: true, short: 0, out_of_range: 0 });
}

#[test]
fn values_go_stale_flags_decide_and_what_is_too_short_is_missing() {
    let plan = Plan::new(&bus(&[""]), &mapping(""), &[2], Lanes::Shared, None).expect("a plan");
    let axles: &[u8] = &[0x10, 0x27, 0x20, 0x4e];
    let (bad, good) = ([0xb8, 0x0b, 0], [0xb8, 0x0b, 1]);
    let first: &[(usize, u32, &[u8], f64)] =
        &[(0, 80, &[0x20, 0x1c], 0.0), (0, 512, &bad, 0.0), (0, 256, axles, 0.1)];
    let row = rows(&plan, first).0[0].1;
    assert!(row.pressing_force_n[0].is_nan() && row.v_m_s > 19.9);
    let late: &[(usize, u32, &[u8], f64)] =
        &[(0, 80, &[0x20, 0x1c], 0.0), (0, 512, &good, 0.3), (0, 256, axles, 0.6)];
    let row = rows(&plan, late).0[0].1;
    assert!(row.v_m_s.is_nan() && row.pressing_force_n[0] > 0.0);
    let (short, taken) = rows(&plan, &[(0, 256, &[0x10, 0x27, 0x20], 0.0)]);
    assert_eq!((short[0].1.wheel_speed_rad_s[0], taken.short), (100.0, 1));
    assert!(short[0].1.wheel_speed_rad_s[1].is_nan());
    let (mark, taken) = rows(&plan, &[(0, 256, &[0xff, 0xff, 0x20, 0x4e], 0.0)]);
    assert!(mark[0].1.wheel_speed_rad_s[0].is_nan() && taken.out_of_range == 1);
    let (none, taken) = rows(&plan, &[(0, 999, &[], 0.0), (1, 256, axles, 0.0)]);
    assert!(none.is_empty() && !taken.wanted);
}

#[test]
fn one_bus_a_wagon_needs_no_numbers_in_names() {
    let plan = Plan::new(&bus(&[""]), &mapping(""), &[2, 2], Lanes::OneEach, Some("Brakes")).expect("a plan");
    let (axles, brakes) = ([0x10, 0x27, 0x20, 0x4e], [0xb8, 0x0b, 1]);
    let (rows, _) = rows(&plan, &[(0, 256, &axles, 0.0), (1, 512, &brakes, 0.1), (0, 512, &brakes, 0.1)]);
    assert_eq!(rows.iter().map(|(wagon, _)| *wagon).collect::<Vec<_>>(), [1, 0]);
    assert!(rows[0].1.wheel_speed_rad_s[0].is_nan() && rows[1].1.wheel_speed_rad_s[0] == 100.0);
}

#[test]
fn what_is_wrong_with_a_mapping_is_said() {
    let said = |names: &[&str], mapping: &Mapping, wheelsets: &[usize]| {
        let plan = Plan::new(&bus(names), mapping, wheelsets, Lanes::Shared, None);
        plan.expect_err("wrong").to_string()
    };
    let unknown = said(&[""], &Mapping { rules: vec![rule("v_m_s", "Train.Speed", 1.0)] }, &[2]);
    assert!(unknown == "no message has \"Train.Speed\"; close are Train.V", "{unknown}");
    let far = said(&[""], &Mapping { rules: vec![rule("v_m_s", "Velocity", 1.0)] }, &[2]);
    assert!(
        far.starts_with("no message has \"Velocity\"; there are 5 values, for example Axles.N1"),
        "{far}"
    );
    let ambiguous = said(&["A", "B"], &Mapping { rules: vec![rule("omega_f_rad_s", "N1", 1.0)] }, &[2]);
    assert_eq!(ambiguous, "\"N1\" is in several messages: AAxles.N1, BAxles.N1; write one of these");
    let shared = said(&[""], &mapping(""), &[2, 2]);
    assert!(shared.starts_with("wagons 1 and 2 both take Axles.N1: "), "{shared}");
    let nothing = said(&[""], &Mapping { rules: vec![rule("f_perp_f_n", "P", 1.0)] }, &[2]);
    assert!(nothing.contains("sample_on"), "{nothing}");
}

/// Each of these once was read.
#[test]
fn what_a_dbc_file_cannot_mean_is_refused_with_the_name_of_its_message_or_signal() {
    let read = |messages: &str| {
        dbc::read(&format!("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: X\n\n{messages}"))
            .map_err(|error| error.to_string())
    };
    let one = |signals: &str| read(&format!("BO_ 80 Train: 4 X\n{signals}"));
    let good = " SG_ A : 0|16@1+ (0.01,0) [0|655] \"km/h\" X\n SG_ B : 16|16@1+ (1,0) [0|0] \"\" X\n";
    assert!(one(good).is_ok());
    // By a switch, two signals share their bits; big-endian ones lie beside little-endian ones.
    let switched = " SG_ S M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ A m0 : 8|8@1+ (1,0) [0|0] \"\" X\n SG_ B m1 : 8|8@1+ (1,0) [0|0] \"\" X\n";
    assert!(one(switched).is_ok());
    assert!(one(" SG_ A : 7|16@0+ (1,0) [0|0] \"\" X\n SG_ B : 16|8@1+ (1,0) [0|0] \"\" X\n").is_ok());
    for (wrong, words) in [
        (one(&good.replace("(0.01,0)", "(0,0)")), ["Train.A", "factor 0"]),
        (one(&good.replace("(0.01,0)", "(1e400,0)")), ["Train.A", "factor inf"]),
        (one(&good.replace("(0.01,0)", "(1,-1e400)")), ["Train.A", "offset -inf"]),
        (one(&good.replace("16|16", "15|16")), ["Train.B", "bits of A"]),
        (one(&good.replace("16|16@1", "12|4@0")), ["Train.B", "bits of A"]),
        (one(&switched.replace("m1", "m0")), ["Train.B", "bits of A"]),
        (one(&good.replace("SG_ B", "SG_ A").replace("16|16", "0|16")), ["Train.A", "twice"]),
        (
            read(&format!("BO_ 80 One: 4 X\n{good}\nBO_ 80 Two: 4 X\n{good}")),
            ["Two", "identifier 80 of message One"],
        ),
        (read(&format!("BO_ 80 One: 4 X\n{good}\nBO_ 81 One: 4 X\n{good}")), ["One", "twice"]),
    ] {
        let said = wrong.expect_err(words[0]);
        assert!(words.iter().all(|words| said.contains(words)), "{words:?}: {said}");
    }
}
