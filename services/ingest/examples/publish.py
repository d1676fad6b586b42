"""Publishes samples of wagon 1 from Python: python3 publish.py INSTANCE_FOLDER (of a train with [source] kind = "external").

Needs `pip install iceoryx2==0.10.0` and, beside this file, `railgrip payloads --python > railgrip_payloads.py`.
"""
import sys
import time

import iceoryx2 as iox2
from railgrip_payloads import Sample, Stamp

config = iox2.config.from_file(iox2.FilePath.new(sys.argv[1] + "/iceoryx2.toml"))
node = iox2.NodeBuilder.new().config(config).create(iox2.ServiceType.Ipc)
name = iox2.ServiceName.new("samples/1")
data = node.service_builder(name).publish_subscribe(iox2.Slice[Sample]).open()
publisher = data.publisher_builder().initial_max_slice_len(32).create()
wake = node.service_builder(name).event().open().notifier_builder().create()
ROLLING = 0b110_0111  # speed, two wheelset speeds, two pressing forces: see `valid` in common/messages/src/sample.rs
for k in range(1000):
    sample = Sample(sequence=k, acquired=Stamp(time.time_ns(), time.monotonic_ns()), time_s=k * 0.01)
    sample.v_m_s, sample.wheelsets, sample.valid = 20.0, 2, ROLLING
    sample.wheel_speed_rad_s[:2] = [20.0 / 0.44] * 2
    loan = publisher.loan_slice_uninit(1)
    loan.payload()[0] = sample
    loan.assume_init().send()
    wake.notify()
    time.sleep(0.002)
time.sleep(0.5)
