// Publishes samples of wagon 1 from C++: publish INSTANCE_FOLDER (of a train with [source] kind = "external").
// Needs the C++ package of iceoryx2 0.10 and, beside this file, `railgrip payloads --c > railgrip_payloads.h`.
#include <string>
#include <time.h>
#include "iox2/iceoryx2.hpp"
#include "railgrip_payloads.h"

static int64_t nanoseconds(clockid_t clock) {
    timespec at{};
    clock_gettime(clock, &at);
    return at.tv_sec * 1'000'000'000LL + at.tv_nsec;
}

int main(int, char** arguments) {
    using namespace iox2;
    auto file = bb::FilePath::create((std::string(arguments[1]) + "/iceoryx2.toml").c_str()).value();
    auto config = Config::from_file(file).value();
    auto node = NodeBuilder().config(config).create<ServiceType::Ipc>().value();
    auto name = ServiceName::create("samples/1").value();
    auto data = node.service_builder(name).publish_subscribe<bb::Slice<railgrip_Sample>>().open().value();
    auto publisher = data.publisher_builder().initial_max_slice_len(32).create().value();
    auto event = node.service_builder(name).event().open().value();
    auto wake = event.notifier_builder().create().value();
    for (uint64_t k = 0; k < 1000; ++k) {
        railgrip_Sample sample{};
        sample.sequence = k;
        sample.acquired = {nanoseconds(CLOCK_REALTIME), static_cast<uint64_t>(nanoseconds(CLOCK_MONOTONIC))};
        sample.time_s = 0.01 * static_cast<double>(k);
        sample.v_m_s = 20.0;
        sample.wheel_speed_rad_s[0] = sample.wheel_speed_rad_s[1] = 20.0 / 0.44;
        sample.wheelsets = 2;
        sample.valid = 0b1100111; // speed, two wheelset speeds, two pressing forces: see common/messages/src/sample.rs
        auto loan = publisher.loan_slice_uninit(1).value();
        send(loan.write_from_fn([&](auto) { return sample; })).value();
        wake.notify().value();
        if (!node.wait(bb::Duration::from_millis(2)).has_value()) { break; } // asked to stop
    }
}
