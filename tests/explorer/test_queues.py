"""Real processes: the newest question counts, nobody waits for what is given up."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
import time
from pathlib import Path

import pytest

from rotor_ida.errors import RotorError
from rotor_ida.explorer import queues
from tests.explorer.asking import ROTOR, SLOW, question
from tests.explorer.conftest import Answering, wait_until

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")


def speeds(count: int, about: str = "motion"):
    return [
        question(about, number=number, machine=ROTOR | {"omega": 1.0 + number / count})
        for number in range(1, count + 1)
    ]


def pid_of(answering: Answering, queue: int) -> int:
    wait_until(lambda: answering.queues._queues[queue]._worker is not None, "a process")
    return answering.queues._queues[queue]._worker._process.pid


def computes(pid: int) -> bool:
    """Return whether a process has work within half a second, though others have the processor."""
    end = time.monotonic() + 0.5
    while time.monotonic() < end:
        if "R" in states_of(pid):
            return True
        time.sleep(0.01)
    return False


def states_of(pid: int) -> list[str]:
    """Return the state of each thread; R is one that runs or waits for a processor."""
    found = Path(f"/proc/{pid}/task").glob("*/stat")
    return [stat.read_text().rpartition(")")[2].split()[0] for stat in found]


def test_of_questions_asked_at_once_only_the_newest_is_answered(answering: Answering):
    answering.ask(1, *speeds(200))
    message = answering.wait_for(1, 200, "motion")
    assert message.facts["rotor"]["omega"] == 2.0
    assert len(answering.got[1]) <= 2


def test_many_moves_of_a_slider_leave_no_backlog(answering: Answering):
    moves, shown = 0, False
    # one that moves on and on still shows something
    for each in speeds(20_000):
        answering.ask(1, each)
        moves += 1
        if moves > 200 and shown:
            break
        shown = bool(answering.got[1])
        time.sleep(0.002)
    answering.wait_for(1, moves, "motion")
    numbers = [each.header["number"] for each in answering.got[1]]
    assert numbers == sorted(set(numbers))
    assert 1 < len(numbers) < moves


def test_a_slow_answer_is_given_up_for_a_newer_question(answering: Answering):
    answering.ask(1, question("starts", number=1, machine=SLOW))
    answering.wait_for(1, 1, "basin")
    answering.ask(1, question("starts", number=2))
    wait_until(lambda: len(answering.parts(1, 2)) == 3, "three pictures of the basin")
    assert answering.got[1][-1].facts["rotor"]["omega"] != SLOW["omega"]
    assert len(answering.parts(1, 1)) < 3


def test_two_rotors_side_by_side_become_finer_together(answering: Answering):
    answering.ask(1, question("starts", number=1, side=0), question("starts", number=2, side=1))
    wait_until(lambda: len(answering.got[1]) == 6, "two basins")
    assert [each.header["side"] for each in answering.got[1]] == [0, 1, 0, 1, 0, 1]


def test_a_page_that_is_gone_stops_its_work(answering: Answering):
    answering.ask(1, question("starts", number=1, machine=SLOW))
    answering.wait_for(1, 1, "basin")
    pid = pid_of(answering, 2)
    assert computes(pid)
    answering.call(lambda: answering.queues.forget(1))
    wait_until(lambda: not computes(pid), "a process at rest")
    told = len(answering.got[1])
    answering.ask(2, question("starts", number=1))
    answering.wait_for(2, 1, "basin")
    assert len(answering.got[1]) == told
    assert pid_of(answering, 2) == pid


def test_a_page_that_is_gone_takes_its_waiting_questions_along(answering: Answering):
    answering.ask(1, *speeds(2), question("starts", number=3))
    answering.call(lambda: answering.queues.forget(1))
    answering.ask(2, question(number=1), question("starts", number=2))
    answering.wait_for(2, 1, "motion")
    answering.wait_for(2, 2, "basin")
    assert [each for each in answering.got[1] if each.part == "basin"] == []


def test_a_process_survives_being_told_again_and_again(answering: Answering):
    """Orders to give up arrive before, during and after the answers that they are about."""
    pids = [pid_of(answering, queue) for queue in range(3)]
    for number in range(1, 101):
        for about in ("motion", "responses", "starts"):
            answering.ask(
                1, question(about, number=number, machine=ROTOR | {"delta0": number / 50})
            )
        time.sleep(0.0007 * (number % 50))
        answering.call(lambda: answering.queues.forget(1))
    for about, part in (("motion", "motion"), ("responses", "settled"), ("starts", "basin")):
        answering.ask(2, question(about, number=1))
        answering.wait_for(2, 1, part)
    assert [pid_of(answering, queue) for queue in range(3)] == pids
    assert not [each for each in answering.got[1] if each.part == "trouble"]


def test_ctrl_c_in_the_terminal_is_no_business_of_the_processes(answering: Answering):
    for queue in range(3):
        assert os.getpgid(pid_of(answering, queue)) != os.getpgid(0)
    pid = pid_of(answering, 0)
    os.kill(pid, signal.SIGINT)
    answering.ask(1, question(number=1))
    os.kill(pid, signal.SIGINT)
    answering.wait_for(1, 1, "motion")
    assert pid_of(answering, 0) == pid


def test_trouble_is_told_and_the_process_lives_on(answering: Answering):
    pid = pid_of(answering, 0)
    answering.ask(1, question(number=1, machine=ROTOR | {"omega": 1e-6}, revolutions=2000))
    trouble = answering.wait_for(1, 1, "trouble")
    assert "duration must be below" in trouble.facts["message"]
    answering.ask(1, question(number=2))
    answering.wait_for(1, 2, "motion")
    assert pid_of(answering, 0) == pid


def test_a_process_that_is_killed_is_replaced_and_the_page_told(answering: Answering):
    answering.ask(1, question("starts", number=1, machine=SLOW))
    answering.wait_for(1, 1, "basin")
    answering.ask(2, question("starts", number=2))
    pid = pid_of(answering, 2)
    os.kill(pid, signal.SIGKILL)
    # whichever of the two was at hand is told; the other is answered, as if nothing had happened
    wait_until(lambda: "trouble" in answering.parts(1, 1) + answering.parts(2, 2), "trouble")
    if "trouble" not in answering.parts(2, 2):
        answering.wait_for(2, 2, "basin")
    answering.ask(1, question("starts", number=3))
    answering.wait_for(1, 3, "basin")
    assert pid_of(answering, 2) != pid
    troubles = [each for page in (1, 2) for each in answering.got[page] if each.part == "trouble"]
    assert [each.facts["message"] for each in troubles] == [queues.DIED]


def test_a_process_at_rest_that_is_killed_is_replaced(answering: Answering):
    worker = answering.queues._queues[0]._worker
    assert worker is not None
    worker.kill()
    wait_until(lambda: worker.has_ended, "the end of a process")
    answering.ask(1, question(number=1))
    answering.wait_for(1, 1, "motion")
    assert "trouble" not in answering.parts(1, 1)


def test_a_process_that_is_deaf_is_ended(answering: Answering, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(queues, "DEAF", 0.2)
    pid = pid_of(answering, 2)
    answering.ask(1, question("starts", number=1, machine=SLOW))
    answering.wait_for(1, 1, "basin")
    os.kill(pid, signal.SIGSTOP)
    answering.ask(1, question("starts", number=2))
    answering.wait_for(1, 2, "basin")
    assert pid_of(answering, 2) != pid
    assert "trouble" not in answering.parts(1, 1)


def test_processes_that_cannot_start_are_told_of(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "path", ["/nowhere"])

    async def open_and_wait() -> None:
        found = queues.Queues()
        try:
            await found.open(lambda *_: None)
        finally:
            await found.close()

    with pytest.raises(RotorError, match="the processes that compute the panels do not start"):
        asyncio.run(open_and_wait())
