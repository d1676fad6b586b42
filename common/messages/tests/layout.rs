//! Pins size and field offsets of every payload version. If this fails, raise the version in the type name and in
//! `payload!`, then write the new figures here.

use std::mem::{offset_of, size_of};

use railgrip_messages::{
    AUDIO_TYPE_NAME, AudioHeader, BogieSample, Estimate, Event, Health, Heard, Heartbeat, Indicator,
    Innovation, MotorSample, Payload, Sample, SourceState, Stamp, Text, Verdict, Verdicts, WheelsetHealth,
};

#[test]
fn layouts_belong_to_their_versions() {
    let sizes = [
        (Sample::TYPE_NAME, size_of::<Sample>(), "railgrip/Sample/v2", 192),
        (Estimate::TYPE_NAME, size_of::<Estimate>(), "railgrip/Estimate/v2", 368),
        (Innovation::TYPE_NAME, size_of::<Innovation>(), "railgrip/Innovation/v2", 216),
        (MotorSample::TYPE_NAME, size_of::<MotorSample>(), "railgrip/MotorSample/v1", 96),
        (BogieSample::TYPE_NAME, size_of::<BogieSample>(), "railgrip/BogieSample/v1", 96),
        (AUDIO_TYPE_NAME, size_of::<AudioHeader>(), "railgrip/AudioBlock/v1", 40),
        (Heard::TYPE_NAME, size_of::<Heard>(), "railgrip/Heard/v1", 112),
        (Event::TYPE_NAME, size_of::<Event>(), "railgrip/Event/v1", 208),
        (Heartbeat::TYPE_NAME, size_of::<Heartbeat>(), "railgrip/Heartbeat/v2", 120),
        (SourceState::TYPE_NAME, size_of::<SourceState>(), "railgrip/SourceState/v1", 232),
        ("railgrip/Indicator/v1", size_of::<Indicator>(), "railgrip/Indicator/v1", 160),
        ("railgrip/WheelsetHealth/v3", size_of::<WheelsetHealth>(), "railgrip/WheelsetHealth/v3", 1688),
        (Health::TYPE_NAME, size_of::<Health>(), "railgrip/Health/v4", 10296),
        ("railgrip/Verdict/v1", size_of::<Verdict>(), "railgrip/Verdict/v1", 232),
        (Verdicts::TYPE_NAME, size_of::<Verdicts>(), "railgrip/Verdicts/v1", 7480),
    ];
    for (name, size, expected_name, expected_size) in sizes {
        println!("{name}: {size} bytes");
        assert_eq!((name, size), (expected_name, expected_size));
    }
    assert_eq!(size_of::<Stamp>(), 16);
    assert_eq!(size_of::<Text>(), Text::CAPACITY);
}

#[test]
fn fields_stay_where_they_are() {
    assert_eq!(
        [
            offset_of!(Sample, acquired),
            offset_of!(Sample, time_s),
            offset_of!(Sample, v_m_s),
            offset_of!(Sample, wheel_speed_rad_s),
            offset_of!(Sample, pressing_force_n),
            offset_of!(Sample, drive_torque_nm),
            offset_of!(Sample, grade_rad),
            offset_of!(Sample, sanding),
            offset_of!(Sample, position_m),
            offset_of!(Sample, load_kg),
            offset_of!(Sample, brake_demand),
            offset_of!(Sample, valid),
            offset_of!(Sample, wsp_active),
            offset_of!(Sample, wheelsets),
            offset_of!(Sample, flags),
        ],
        [8, 24, 32, 40, 72, 104, 136, 144, 152, 160, 168, 176, 180, 184, 188]
    );
    assert_eq!(
        [
            offset_of!(Estimate, published_monotonic_ns),
            offset_of!(Estimate, mu_w),
            offset_of!(Estimate, mu_w_wheelset),
            offset_of!(Estimate, mu_b),
            offset_of!(Estimate, mu_b_mean),
            offset_of!(Estimate, slip),
            offset_of!(Estimate, normal_load_n),
            offset_of!(Estimate, pressing_force_n),
            offset_of!(Estimate, nis),
            offset_of!(Estimate, observable),
            offset_of!(Estimate, rejected),
            offset_of!(Estimate, flags),
            offset_of!(Estimate, state),
        ],
        [24, 48, 64, 128, 192, 208, 240, 272, 320, 332, 344, 352, 360]
    );
    assert_eq!(
        [
            offset_of!(Innovation, innovation),
            offset_of!(Innovation, innovation_variance),
            offset_of!(Innovation, test_ratio),
            offset_of!(Innovation, rejected),
        ],
        [16, 80, 144, 208]
    );
}

#[test]
fn bytes_survive_the_way_there_and_back() {
    let health = Health { wagon: 7, wheelsets: 2, ..Health::default() };
    let bytes = bytemuck::bytes_of(&health).to_vec();
    assert_eq!(bytemuck::pod_read_unaligned::<Health>(&bytes), health);
    assert!(bytemuck::try_from_bytes::<Sample>(&bytes[..100]).is_err());
}
