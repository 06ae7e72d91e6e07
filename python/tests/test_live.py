"""The live view, controlled as its page does it."""

from __future__ import annotations

import base64
import http.client
import json
import struct
import threading
from typing import Any
from urllib.parse import urlsplit

import momentree
import pytest


def chain() -> momentree.Simulation:
    model = momentree.Model()
    link: dict[str, Any] = {"mass": 1, "com": (0, 0, -0.5), "inertia": 0.1, "joint": momentree.Revolute((0, 1, 0))}
    model.add("upper", **link, q=[0.7])
    model.add("lower", **link, parent="upper", at=(0, 0, -1))
    return momentree.Simulation(model)


class Page:
    def __init__(self, view: momentree.LiveView) -> None:
        address = urlsplit(view.address)
        self.host, self.path = address.netloc, address.path
        stream = http.client.HTTPConnection(self.host, timeout=60)
        stream.request("GET", self.path + "/stream")
        self.answer = stream.getresponse()

    def next(self, kind: str) -> Any:
        while True:
            line = self.answer.readline().decode()
            assert line
            if line.startswith("data: ") and json.loads(line[6:])["type"] == kind:
                return json.loads(line[6:])

    def act(self, **message: Any) -> None:
        connection = http.client.HTTPConnection(self.host, timeout=60)
        connection.request("POST", self.path + "/act", json.dumps(message))
        assert connection.getresponse().status == 204


def time_of(frame: Any) -> float:
    """The first of its numbers."""
    return float(struct.unpack_from("<d", base64.b64decode(frame["numbers"]))[0])


def test_page_shows_the_simulation_and_changes_it() -> None:
    sim = chain()
    with sim.show(title="Chain", browser=False) as view:
        page = Page(view)
        assert page.next("loaded")["world"]["model"]["title"] == "Chain"
        page.act(type="act", action={"break": "lower"})
        assert view.update()
        assert [event.actions[0].kind for event in sim.events] == ["break"]
        assert len(page.next("topology")["topology"]["mechanisms"]) == 2
        assert view.pages == 1
    with pytest.raises(OSError):
        Page(view)


def test_run_in_real_time_takes_the_steps_of_a_run_without_a_page() -> None:
    alone, shown = chain(), chain()
    alone.run(0.2)
    with shown.show(browser=False, speed=4) as view:
        assert view.run(0.2)
    assert shown.time == 0.2
    assert list(shown.q) == pytest.approx(list(alone.q), abs=1e-13)


def test_sliders_call_the_program() -> None:
    sim = chain()
    told: list[float] = []

    def wind(speed: float) -> None:
        told.append(speed)
        sim.apply(momentree.lock("lower"))

    with sim.show(browser=False) as view:
        view.slider("wind", 0, 20, 3, unit="m/s", changed=wind)
        view.slider("gain", -1, 1, 0)
        page = Page(view)
        assert [each["name"] for each in page.next("sliders")["sliders"]] == ["wind", "gain"]
        page.act(type="slider", name="wind", value=7.5)
        page.act(type="slider", name="gain", value=-0.25)
        view.run(sim.time + 0.02)
        assert told == [7.5]
        assert (view["wind"], view["gain"]) == (7.5, -0.25)
        assert len(sim.events) == 1
        with pytest.raises(momentree.Error, match="no slider 'rain'"):
            view["rain"]
        with pytest.raises(momentree.Error, match="already"):
            view.slider("wind", 0, 1)


def test_pause_and_stop() -> None:
    sim = chain()
    with sim.show(browser=False, paused=True) as view:
        page = Page(view)
        page.next("playing")
        page.act(type="speed", factor=0.5)

        def reader() -> None:
            page.act(type="play", on=True)
            while time_of(page.next("frame")["frame"]) < 0.05:
                pass
            page.act(type="stop")

        thread = threading.Thread(target=reader)
        thread.start()
        assert not view.run(1000)
        thread.join()
        assert view.stopped
        assert 0.05 <= sim.time < 500
        assert not view.update()


def test_exceptions_end_a_run() -> None:
    sim = chain()
    sim.drive("upper", lambda context: 1 / 0)
    with sim.show(browser=False) as view, pytest.raises(ZeroDivisionError):
        view.run(1)


def test_mistakes_are_named() -> None:
    sim = chain()
    with pytest.raises(momentree.Error, match="speed"):
        sim.show(browser=False, speed=0)
    with sim.show(browser=False) as view:
        port = int(urlsplit(view.address).port or 0)
        with pytest.raises(momentree.Error, match="in use"):
            chain().show(browser=False, port=port)
        with pytest.raises(momentree.Error, match="until"):
            view.run(float("nan"))
