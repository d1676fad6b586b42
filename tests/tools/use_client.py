"""Asks a running train through the client that was generated from its description."""

import sys

from client import Client
from client.api.alerts import alerts
from client.api.health import ready
from client.api.history import events, history
from client.api.train import train
from client.api.wagons import wagon, wagons

client = Client(base_url=sys.argv[1], raise_on_unexpected_status=True)
assert ready.sync(client=client).status == "ok"
assert train.sync(client=client).wagons == 3
assert [row.id for row in wagons.sync(client=client).wagons] == [1, 2, 3]
assert wagon.sync(2, client=client).name == "wagon-2"
assert wagon.sync(9, client=client).status == 404
assert alerts.sync(client=client, limit=5) is not None
assert len(events.sync(client=client).events) > 0
stored = history.sync(1, client=client, step="10s")
assert len(stored.time) == len(stored.unix_s) > 0
print(f"the client reads {len(stored.time)} steps of history")
