//! The payloads for programs in other languages: a C header and a Python module, written from the layouts themselves.

use railgrip_messages::{
    BogieSample, Estimate, Event, Health, Heard, Heartbeat, Indicator, Innovation, MotorSample, Payload,
    Sample, SourceState, Stamp, Text, Verdict, Verdicts, WheelsetHealth,
};
use std::fmt::Write as _;
use std::mem::offset_of;

/// What a field holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    U8,
    U32,
    U64,
    I64,
    F64,
    /// Another of these structures.
    Of(&'static str),
}

/// One field: so many of a kind, from an offset on.
#[derive(Debug, Clone, Copy)]
struct Field {
    name: &'static str,
    kind: Kind,
    /// 0: one, and no array.
    count: usize,
    offset: usize,
}

/// One structure. It has no padding, so that its fields fill it.
struct Layout {
    name: &'static str,
    type_name: &'static str,
    bytes: usize,
    fields: Vec<Field>,
}

/// The kind and number of a field, from its type.
trait Held {
    const KIND: Kind;
    const COUNT: usize = 0;
}

macro_rules! held {
    ($($type:ty: $kind:expr),+ $(,)?) => {
        $(impl Held for $type {
            const KIND: Kind = $kind;
        })+
    };
}

held!(u8: Kind::U8, u32: Kind::U32, u64: Kind::U64, i64: Kind::I64, f64: Kind::F64);
held!(Stamp: Kind::Of("Stamp"), Text: Kind::Of("Text"), Indicator: Kind::Of("Indicator"));
held!(WheelsetHealth: Kind::Of("WheelsetHealth"), Verdict: Kind::Of("Verdict"));

impl<T: Held, const N: usize> Held for [T; N] {
    const KIND: Kind = T::KIND;
    const COUNT: usize = N;
}

/// The kind and number of what a function gives a reference to.
fn held_by<S, T: Held>(_field: impl Fn(&S) -> &T) -> (Kind, usize) {
    (T::KIND, T::COUNT)
}

macro_rules! layout {
    ($type:ident, $type_name:expr, $($field:ident),+ $(,)?) => {
        Layout {
            name: stringify!($type),
            type_name: $type_name,
            bytes: size_of::<$type>(),
            fields: vec![$({
                let (kind, count) = held_by(|whole: &$type| &whole.$field);
                Field { name: stringify!($field), kind, count, offset: offset_of!($type, $field) }
            }),+],
        }
    };
}

/// Every structure, those that others hold first.
fn layouts() -> Vec<Layout> {
    vec![
        layout!(Stamp, "railgrip/Stamp/v1", unix_ns, monotonic_ns),
        Layout {
            name: "Text",
            type_name: "railgrip/Text/v1",
            bytes: size_of::<Text>(),
            fields: vec![Field { name: "bytes", kind: Kind::U8, count: Text::CAPACITY, offset: 0 }],
        },
        layout!(Indicator, "railgrip/Indicator/v1", value, low, high, grade, known, reason),
        layout!(
            WheelsetHealth,
            "railgrip/WheelsetHealth/v3",
            indicator,
            brake_friction_ratio,
            slide_energy_j,
            slide_s,
            mu_b,
            mu_b_sigma,
            mu_w,
            mu_w_sigma,
            slip,
            pressing_force_n,
            adhesion_available_is_bound,
            observable,
            sliding,
            wsp_active
        ),
        layout!(
            Sample,
            Sample::TYPE_NAME,
            sequence,
            acquired,
            time_s,
            v_m_s,
            wheel_speed_rad_s,
            pressing_force_n,
            drive_torque_nm,
            grade_rad,
            sanding,
            position_m,
            load_kg,
            brake_demand,
            valid,
            wsp_active,
            wheelsets,
            flags
        ),
        layout!(
            MotorSample,
            MotorSample::TYPE_NAME,
            sequence,
            acquired,
            time_s,
            current_a,
            voltage_v,
            motor_speed_rad_s,
            roller_speed_rad_s,
            generator_current_a,
            valid,
            flags
        ),
        layout!(
            BogieSample,
            BogieSample::TYPE_NAME,
            sequence,
            acquired,
            time_s,
            shaft_torque_nm,
            load_cell_n,
            brake_pressure_pa,
            load_n,
            roller_pulses,
            wheel_pulses,
            valid,
            flags
        ),
        layout!(
            Estimate,
            Estimate::TYPE_NAME,
            sequence,
            acquired,
            published_monotonic_ns,
            time_s,
            v_m_s,
            mu_w,
            mu_w_sigma,
            mu_w_wheelset,
            mu_w_wheelset_sigma,
            mu_b,
            mu_b_sigma,
            mu_b_mean,
            mu_b_mean_sigma,
            slip,
            normal_load_n,
            pressing_force_n,
            adhesion_peak,
            adhesion_peak_sigma,
            nis,
            nis_dof,
            observable,
            sliding,
            wsp_active,
            rejected,
            observability_rank,
            flags,
            wheelsets,
            state,
            reserved
        ),
        layout!(
            Innovation,
            Innovation::TYPE_NAME,
            sequence,
            time_s,
            innovation,
            innovation_variance,
            test_ratio,
            rejected,
            fused
        ),
        layout!(
            Health,
            Health::TYPE_NAME,
            sequence,
            acquired,
            published_monotonic_ns,
            time_s,
            wagon,
            wheelsets,
            grade,
            condition,
            condition_probability,
            v_m_s,
            mu_w,
            mu_w_sigma,
            mu_b_mean,
            mu_b_mean_sigma,
            position_m,
            braking_s,
            samples,
            missed,
            rejected,
            indicator,
            brake_applied,
            brake_applications,
            pressing_force_n,
            sanding_now,
            wheelset,
            adhesion_available_is_bound,
            faulty_sensors,
            vehicle
        ),
        layout!(
            Heard,
            Heard::TYPE_NAME,
            sequence,
            acquired,
            published_monotonic_ns,
            wagon,
            state,
            condition,
            known,
            wet_probability,
            level_db,
            missed,
            decided,
            decided_condition,
            kept,
            sample_rate_hz,
            decided_adhesion,
            optimum_slip,
            optimum_adhesion
        ),
        layout!(Event, Event::TYPE_NAME, sequence, stamp, time_s, kind, wagon, wheelset, grade, values, text),
        layout!(
            Heartbeat,
            Heartbeat::TYPE_NAME,
            sequence,
            stamp,
            process,
            wagon,
            pid,
            unseen,
            received,
            missed,
            rejected,
            late,
            published,
            step_p50_ns,
            step_p99_ns,
            latency_p50_ns,
            latency_p99_ns,
            uptime_s
        ),
        layout!(SourceState, SourceState::TYPE_NAME, sequence, stamp, wagon, drift_known, drift_ppm, counts),
        layout!(
            Verdict,
            "railgrip/Verdict/v1",
            wagons,
            probability,
            instead_probability,
            instead,
            cause,
            grade,
            wheelsets,
            brakings_seen,
            number,
            found_t_s,
            reason
        ),
        layout!(
            Verdicts,
            Verdicts::TYPE_NAME,
            sequence,
            stamp,
            time_s,
            instants,
            brakings,
            count,
            wagons,
            reserved,
            verdict
        ),
    ]
}

/// A header for C and C++: structures in the namespace of their prefix, with sizes that the compiler checks.
pub(super) fn c_header() -> String {
    let mut text = "/* The payloads of railgrip, written by `railgrip payloads --c`. Do not edit: layouts carry versions. */\n\
                    #ifndef RAILGRIP_PAYLOADS_H\n#define RAILGRIP_PAYLOADS_H\n#include <stddef.h>\n#include <stdint.h>\n#ifdef __cplusplus\n\
                    #define RAILGRIP_ASSERT static_assert\n#else\n#define RAILGRIP_ASSERT _Static_assert\n#endif\n"
        .to_owned();
    for layout in layouts() {
        let name = layout.name;
        // Writing into a string cannot fail.
        let _ = write!(text, "\n/* {} */\ntypedef struct railgrip_{name} {{\n", layout.type_name);
        for field in &layout.fields {
            let kind = match field.kind {
                Kind::U8 => "uint8_t".to_owned(),
                Kind::U32 => "uint32_t".to_owned(),
                Kind::U64 => "uint64_t".to_owned(),
                Kind::I64 => "int64_t".to_owned(),
                Kind::F64 => "double".to_owned(),
                Kind::Of(other) => format!("railgrip_{other}"),
            };
            let count = if field.count > 0 { format!("[{}]", field.count) } else { String::new() };
            let _ = writeln!(text, "    {kind} {}{count};", field.name);
        }
        // By this name iceoryx2 tells types apart in C++.
        let _ = writeln!(
            text,
            "#ifdef __cplusplus\n    static constexpr const char *IOX2_TYPE_NAME = \"{}\";\n#endif",
            layout.type_name
        );
        let upper = name.to_uppercase();
        let _ = write!(
            text,
            "}} railgrip_{name};\n#define RAILGRIP_{upper}_TYPE_NAME \"{}\"\n\
             RAILGRIP_ASSERT(sizeof(railgrip_{name}) == {}, \"layout of {name}\");\n",
            layout.type_name, layout.bytes
        );
        for field in &layout.fields {
            let (field, offset) = (field.name, field.offset);
            let _ = writeln!(
                text,
                "RAILGRIP_ASSERT(offsetof(railgrip_{name}, {field}) == {offset}, \"layout of {name}.{field}\");"
            );
        }
    }
    text.push_str("\n#endif\n");
    text
}

/// A module for Python: `ctypes` structures that the iceoryx2 package takes as they are.
pub(super) fn python_module() -> String {
    let mut text = "\"\"\"The payloads of railgrip, written by `railgrip payloads --python`. Do not edit: layouts carry versions.\"\"\"\n\n\
                    import ctypes\n"
        .to_owned();
    for layout in layouts() {
        let name = layout.name;
        let _ = write!(text, "\n\nclass {name}(ctypes.Structure):\n    _fields_ = [\n");
        for field in &layout.fields {
            let kind = match field.kind {
                Kind::U8 => "ctypes.c_uint8",
                Kind::U32 => "ctypes.c_uint32",
                Kind::U64 => "ctypes.c_uint64",
                Kind::I64 => "ctypes.c_int64",
                Kind::F64 => "ctypes.c_double",
                Kind::Of(other) => other,
            };
            let count = if field.count > 0 { format!(" * {}", field.count) } else { String::new() };
            let _ = writeln!(text, "        (\"{}\", {kind}{count}),", field.name);
        }
        let _ = write!(
            text,
            "    ]\n\n    @staticmethod\n    def type_name():\n        return \"{}\"\n\n\nassert ctypes.sizeof({name}) == {}\n",
            layout.type_name, layout.bytes
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fields_fill_every_structure_so_none_is_forgotten() {
        let all = layouts();
        let bytes = |kind: Kind| match kind {
            Kind::U8 => 1,
            Kind::U32 => 4,
            Kind::U64 | Kind::I64 | Kind::F64 => 8,
            Kind::Of(other) => {
                all.iter().find(|layout| layout.name == other).map_or(0, |layout| layout.bytes)
            }
        };
        for layout in &all {
            let mut end = 0;
            for field in &layout.fields {
                assert_eq!(field.offset, end, "{}.{}", layout.name, field.name);
                end += bytes(field.kind) * field.count.max(1);
            }
            assert_eq!(end, layout.bytes, "{}", layout.name);
        }
    }

    #[test]
    fn both_languages_name_the_version_and_the_size() {
        let (c, python) = (c_header(), python_module());
        assert!(c.contains("#define RAILGRIP_SAMPLE_TYPE_NAME \"railgrip/Sample/v2\""), "{c}");
        assert!(c.contains("    double wheel_speed_rad_s[4];") && c.contains("    railgrip_Stamp acquired;"));
        assert!(
            python.contains("(\"wheel_speed_rad_s\", ctypes.c_double * 4),")
                && python.contains("class Sample(")
        );
        assert!(python.contains(&format!("assert ctypes.sizeof(Sample) == {}", size_of::<Sample>())));
    }
}
