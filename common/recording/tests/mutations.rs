//! Five hundred recordings that somebody, or something, has spoilt: each is read or refused with words, none makes the program panic,
//! and what is not there is never read as a figure.

use railgrip_recording::{Mapping, Quantity, Recording, Strictness, first_minute, proposal, survey};

const CASES: u64 = 500;
const ROWS: usize = 120;
const HEADER: [&str; 8] =
    ["t_s", "v_m_s", "omega_f_rad_s", "omega_r_rad_s", "f_perp_f_n", "f_perp_r_n", "grade_rad", "load_kg"];
const WORDS: [&str; 14] =
    ["", "", "", "", "NaN", "inf", "-inf", "1e400", "-1e308", "0x10", "none", "1,5", "\u{202e}", "\"a"];

/// The same numbers for the same seed.
struct Dice(u64);

impl Dice {
    fn below(&mut self, most: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) % most as u64) as usize
    }
}

/// A sound recording, none of whose values is zero.
fn sound() -> Vec<Vec<String>> {
    let row = |k: usize| {
        let v = 20.0 - 0.01 * k as f64;
        let cells = [10.0 + 0.01 * k as f64, v, v / 0.46, v / 0.46, 9e3, 8e3, 0.002, 42_000.0];
        cells.iter().map(f64::to_string).collect()
    };
    (0..ROWS).map(row).collect()
}

/// A spoilt one, and whether its cells still stand under the names of their columns.
fn spoilt(seed: u64) -> (String, bool) {
    let mut dice = Dice(seed);
    let mut header: Vec<String> = HEADER.iter().map(|name| (*name).to_owned()).collect();
    let mut rows = sound();
    let mut in_order = true;
    for _ in 0..1 + dice.below(2) {
        let (row, column) = (dice.below(ROWS - 20), dice.below(HEADER.len()));
        match dice.below(10) {
            0..=2 => {
                let word = WORDS[dice.below(WORDS.len())];
                rows[row].get_mut(column).into_iter().for_each(|cell| cell.replace_range(.., word));
            }
            // A row that was cut short has no such cell.
            3 => rows.iter_mut().filter_map(|cells| cells.get_mut(column)).for_each(String::clear),
            4 => rows[row..row + 20]
                .iter_mut()
                .filter_map(|cells| cells.get_mut(column))
                .for_each(String::clear),
            5 => rows[row].iter_mut().for_each(String::clear),
            6 => {
                rows[row].pop();
                in_order = false;
            }
            7 => {
                header[column] = WORDS[dice.below(WORDS.len())].to_owned();
                in_order = false;
            }
            8 => rows.swap(row, row + 1),
            _ => {
                let copy = rows[row].clone();
                rows.insert(row, copy);
                rows.truncate(ROWS);
            }
        }
    }
    let lines = rows.iter().map(|cells| cells.join(","));
    let mut text = std::iter::once(header.join(",")).chain(lines).collect::<Vec<_>>().join("\n");
    if dice.below(4) == 0 {
        let at = text.floor_char_boundary(dice.below(text.len()));
        match dice.below(3) {
            0 => text.truncate(at),
            1 => text.insert(at, ['\0', '\n', ',', '"', 'ä'][dice.below(5)]),
            _ => text.insert_str(at, &"\n".repeat(5)),
        }
        in_order = false;
    }
    (text, in_order)
}

#[test]
fn five_hundred_spoilt_recordings_are_read_or_refused_and_nothing_is_made_up() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("run.csv");
    let (mut read, mut refused, mut empty) = (0, 0, 0);
    for seed in 0..CASES {
        let (text, in_order) = spoilt(seed);
        std::fs::write(&path, &text).expect("write");
        // None of these may panic.
        if let Ok(surveyed) = survey(&path) {
            assert!(proposal(&surveyed, str::to_owned).starts_with("[mapping]"), "{seed}");
            let minute = first_minute(&path, &surveyed).expect("what was surveyed is read");
            assert!(
                minute.iter().all(|one| one.points.iter().all(|point| point[1] != 0.0)),
                "{seed}: a zero"
            );
        }
        let strict = Recording::read(&path, Strictness::Strict);
        for read_at in [strict, Recording::read_mapped(&path, &Mapping::default(), Strictness::Tolerant)] {
            let recording = match read_at {
                Ok(recording) => recording,
                Err(error) => {
                    let said = error.to_string();
                    assert!(said.contains("run.csv") && said.len() < 1000, "{seed}: {said}");
                    refused += 1;
                    continue;
                }
            };
            read += 1;
            for row in recording.rows() {
                for quantity in
                    [Quantity::Speed, Quantity::WheelSpeed, Quantity::PressingForce, Quantity::Load]
                {
                    for wheelset in 0..if quantity.per_wheelset() { 2 } else { 1 } {
                        assert!(row.get(quantity, wheelset) != 0.0, "{seed}: a zero that nobody measured");
                    }
                }
            }
            if !in_order {
                continue;
            }
            // Cell by cell: what is blank in the file is nothing in the recording.
            for (line, row) in text.lines().skip(1).zip(recording.rows()) {
                let cells: Vec<&str> = line.split(',').collect();
                let places =
                    [(1, Quantity::Speed, 0), (2, Quantity::WheelSpeed, 0), (5, Quantity::PressingForce, 1)];
                for (at, quantity, wheelset) in places {
                    if cells[at].is_empty() {
                        assert!(row.get(quantity, wheelset).is_nan(), "{seed}: {line}");
                        empty += 1;
                    }
                }
            }
        }
    }
    println!("{read} read, {refused} refused, {empty} empty cells");
    assert!(
        read > 100 && refused > 100 && empty > 100,
        "{read} read, {refused} refused, {empty} empty cells"
    );
}
