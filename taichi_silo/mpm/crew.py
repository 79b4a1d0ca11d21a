"""Runs whose steps are done together, by launches of all.

One run works at a time, until its solver asks for steps. When all have asked, as many are done as the least asks for;
whoever has its steps goes on. Nothing of a run knows of the others. Each is a greenlet, as Taichi lets only the thread
that has started it make fields.
"""

import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from greenlet import getcurrent, greenlet

from taichi_silo.mpm import one_taichi, runtime
from taichi_silo.mpm.joint_steps import JointSteps, Request

if TYPE_CHECKING:
    from taichi_silo.mpm.tasks import Tasks


class Crew:
    """Runs that take turns: functions, each of which keeps what it raises to itself.

    Solvers whose tasks differ, or that were made when others had begun, are launched apart: what is compiled is for a
    certain set of solvers, and lasts until none of them asks for steps any more.
    """

    def __init__(self, works: Sequence[Callable[[], None]]):
        self.hub = getcurrent()
        self.ready = [greenlet(work, self.hub) for work in works]
        self.asked: dict[Tasks, tuple[greenlet, Request]] = {}
        self.at_end: list[greenlet] = []  # that wait for the end of the others
        self.joint: list[JointSteps] = []
        self.share: defaultdict[Tasks, float] = defaultdict(float)  # of each solver in the launches since it asked [s]
        self.away: defaultdict[greenlet, float] = defaultdict(float)  # in which a run waited while others worked [s]

    def work(self) -> None:
        """Do all."""
        with one_taichi.within(self):
            while self.ready or self.asked or self.at_end:
                if self.ready:
                    self.ready.pop(0).switch()
                elif self.asked:
                    self._launch()
                else:
                    self.ready, self.at_end = self.at_end, []

    def run(self, solver: "Tasks", request: Request) -> None:
        """Do the steps of a request, together with those of the others."""
        self.asked[solver] = getcurrent(), request
        begun = time.perf_counter()
        self.hub.switch()
        self.away[getcurrent()] += time.perf_counter() - begun - self.share.pop(solver)

    def seconds(self) -> float:
        """Of a clock that stands still while others work for themselves."""
        return time.perf_counter() - self.away[getcurrent()]

    def wait_for_end(self) -> None:
        """Wait until every other run has come here, too, or has ended."""
        self.at_end.append(getcurrent())
        self.hub.switch()

    def _launch(self) -> None:
        """Do as many steps of all that ask as the least asks for; what goes wrong, goes wrong for those that asked."""
        of_joint = [one for one in self.joint if any(member in self.asked for member in one.members)]
        if not of_joint:
            self.joint = of_joint = joined(list(self.asked))
        for one in of_joint:
            asking = {member: self.asked[member][1] for member in one.members if member in self.asked}
            count = min(request.asked for request in asking.values())
            begun = time.perf_counter()
            try:
                one.run(asking, count)
                runtime.wait()
            except Exception as error:  # noqa: BLE001 - each run tells of it
                for member in asking:
                    self.asked.pop(member)[0].throw(error)
                continue
            took = (time.perf_counter() - begun) / len(asking)
            for member, request in asking.items():
                self.share[member] += took
                waiting = self.asked.pop(member)[0]
                if request.asked == count:
                    self.ready.append(waiting)
                else:
                    self.asked[member] = waiting, request.after(count)


def joined(solvers: Sequence["Tasks"]) -> list[JointSteps]:
    """Launches of all: by the same those with the same tasks, as many as a kernel may use trees of fields."""
    alike: dict[tuple, list[Tasks]] = {}
    for one in solvers:
        alike.setdefault(tuple(task.over for task in one.tasks), []).append(one)
    found, most = [], runtime.most_trees()
    for kind in alike.values():
        groups: list[tuple[list[Tasks], set[int]]] = []
        for one in kind:
            used = one.trees
            if not groups or len(groups[-1][1] | used) >= most:  # one more for the plan
                groups.append(([], set()))
            groups[-1][0].append(one)
            groups[-1][1].update(used)
        found += [JointSteps(tuple(members)) for members, _ in groups]
    return found
