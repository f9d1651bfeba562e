"""thenar: supervisory control of discrete-event systems.

Write what a system can do as small automata and what it may do as specifications; get the largest supervisor
that is provably safe and never gets stuck, the reason for each of its decisions, and a certificate.

>>> import thenar
>>> result = thenar.synthesize(thenar.library.glr.problem())
>>> result.supervisor
Supervisor: 2,809 states, 6,076 transitions, 1,567 disablements
>>> print(thenar.explain_disabled(result, "approach_2").verdict)
forbidden
"""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING

from thenar.errors import (
    AlphabetClash,
    CertificateError,
    Fault,
    InputError,
    LimitReached,
    Mistake,
    ModelError,
    ThenarError,
    UnknownName,
)
from thenar.explicit.control import closed_loop, condat, is_controllable, supcon
from thenar.explicit.language import complement, is_isomorphic, is_sublanguage, minimize, project
from thenar.explicit.products import meet, selfloop, shuffle, sync
from thenar.explicit.reach import coreachable, is_nonblocking, is_nonconflicting, reachable, shortest_trace, trim
from thenar.model.automaton import Automaton
from thenar.model.display import set_html_formatter as _set_html_formatter
from thenar.model.events import Alphabet, Event
from thenar.model.limits import Limits
from thenar.model.problem import Problem
from thenar.model.supervisor import ControlPattern, Supervisor
from thenar.model.trace import Check, Trace
from thenar.synthesis.api import Size, SynthesisResult, synthesize

if TYPE_CHECKING:
    from thenar import library
    from thenar.explicit.cost import CostToGo, cheapest_trace, cost_to_go
    from thenar.explicit.forcing import ForcingSupervisor, is_forcibly_controllable, supcon_forcing
    from thenar.explicit.nondeterminism import determinise
    from thenar.explicit.reduction import Reduction, localize, supreduce
    from thenar.explicit.regular import (
        concatenation,
        difference,
        inverse_project,
        kleene_star,
        left_quotient,
        prefix_closure,
        quotient,
        reverse,
        union,
    )
    from thenar.explicit.relabel import relabel
    from thenar.explicit.relative import is_relatively_closed, sup_relatively_closed
    from thenar.explicit.strings import count_strings, enabled_after, sample
    from thenar.explicit.superlanguage import infcon
    from thenar.explicit.timed import is_activity_loop_free, timed
    from thenar.hand.campaign import Campaign, run_campaign
    from thenar.hand.episode import Episode, run_episode
    from thenar.hand.objects import Block
    from thenar.io import Saved, dumps, load, loads, save
    from thenar.model.extended import (
        Condition,
        ExtendedAutomaton,
        ExtendedProblem,
        Variable,
        disables,
        invariant,
        needs,
    )
    from thenar.render import html, mermaid, svg, table
    from thenar.runtime.driver import Detector, Driver, Signal, Skill
    from thenar.runtime.executor import execute
    from thenar.runtime.record import Log, LogWriter, read_log
    from thenar.runtime.replay import Replay, replay
    from thenar.runtime.run import Run
    from thenar.symbolic.guards import Guards, guards, supervised
    from thenar.symbolic.synthesis import SymbolicSupervisor
    from thenar.synthesis.certificate import certificate
    from thenar.synthesis.deploy import fit_to_run
    from thenar.synthesis.explain import (
        Explanation,
        Violation,
        explain,
        explain_disabled,
        explain_empty,
        explain_removed,
    )
    from thenar.synthesis.implementation import (
        fit_for_sampling,
        has_bounded_response,
        is_avalanche_free,
        is_choice_free,
        is_confluent,
        is_delay_insensitive,
        is_interleave_insensitive,
        is_nonblocking_under_control,
        longest_burst,
    )
    from thenar.synthesis.lint import lint
    from thenar.synthesis.modular import ModularResult, synthesize_modular
    from thenar.synthesis.optimal import optimal_supervisor
    from thenar.synthesis.simulate import Status, Step, random_trace, simulate
    from thenar.synthesis.verify import Verdict, verify

# Imported when first used: import thenar pulls NumPy and the kernel only.
_HOMES = {
    "thenar.explicit.cost": "CostToGo cheapest_trace cost_to_go",
    "thenar.explicit.forcing": "ForcingSupervisor is_forcibly_controllable supcon_forcing",
    "thenar.explicit.nondeterminism": "determinise",
    "thenar.explicit.regular": (
        "concatenation difference inverse_project kleene_star left_quotient prefix_closure quotient reverse union"
    ),
    "thenar.explicit.strings": "count_strings enabled_after sample",
    "thenar.explicit.timed": "is_activity_loop_free timed",
    "thenar.hand.campaign": "Campaign run_campaign",
    "thenar.hand.episode": "Episode run_episode",
    "thenar.hand.objects": "Block",
    "thenar.io": "Saved dumps load loads save",
    "thenar.model.extended": "Condition ExtendedAutomaton ExtendedProblem Variable disables invariant needs",
    "thenar.render": "html mermaid svg table",
    "thenar.runtime.driver": "Detector Driver Signal Skill",
    "thenar.runtime.executor": "execute",
    "thenar.runtime.record": "Log LogWriter read_log",
    "thenar.runtime.replay": "Replay replay",
    "thenar.runtime.run": "Run",
    "thenar.symbolic.guards": "Guards guards supervised",
    "thenar.symbolic.synthesis": "SymbolicSupervisor",
    "thenar.synthesis.certificate": "certificate",
    "thenar.synthesis.deploy": "fit_to_run",
    "thenar.synthesis.explain": "Explanation Violation explain explain_disabled explain_empty explain_removed",
    "thenar.synthesis.implementation": (
        "fit_for_sampling has_bounded_response is_avalanche_free is_choice_free is_confluent is_delay_insensitive "
        "is_interleave_insensitive is_nonblocking_under_control longest_burst"
    ),
    "thenar.synthesis.lint": "lint",
    "thenar.synthesis.modular": "ModularResult synthesize_modular",
    "thenar.synthesis.optimal": "optimal_supervisor",
    "thenar.synthesis.simulate": "Status Step random_trace simulate",
    "thenar.synthesis.verify": "Verdict verify",
    "thenar.explicit.relabel": "relabel",
    "thenar.explicit.reduction": "Reduction localize supreduce",
    "thenar.explicit.relative": "is_relatively_closed sup_relatively_closed",
    "thenar.explicit.superlanguage": "infcon",
    "thenar": "library",
}
_LATER = {name: home for home, names in _HOMES.items() for name in names.split()}

__all__ = [
    "Alphabet",
    "AlphabetClash",
    "Automaton",
    "Block",
    "Campaign",
    "CertificateError",
    "Check",
    "Condition",
    "ControlPattern",
    "CostToGo",
    "Detector",
    "Driver",
    "Episode",
    "Event",
    "Explanation",
    "ExtendedAutomaton",
    "ExtendedProblem",
    "Fault",
    "ForcingSupervisor",
    "Guards",
    "InputError",
    "LimitReached",
    "Limits",
    "Log",
    "LogWriter",
    "Mistake",
    "ModelError",
    "ModularResult",
    "Problem",
    "Reduction",
    "Replay",
    "Run",
    "Saved",
    "Signal",
    "Size",
    "Skill",
    "Status",
    "Step",
    "Supervisor",
    "SymbolicSupervisor",
    "SynthesisResult",
    "ThenarError",
    "Trace",
    "UnknownName",
    "Variable",
    "Verdict",
    "Violation",
    "certificate",
    "cheapest_trace",
    "closed_loop",
    "complement",
    "concatenation",
    "condat",
    "coreachable",
    "cost_to_go",
    "count_strings",
    "determinise",
    "difference",
    "disables",
    "dumps",
    "enabled_after",
    "execute",
    "explain",
    "explain_disabled",
    "explain_empty",
    "explain_removed",
    "fit_for_sampling",
    "fit_to_run",
    "guards",
    "has_bounded_response",
    "html",
    "infcon",
    "invariant",
    "inverse_project",
    "is_activity_loop_free",
    "is_avalanche_free",
    "is_choice_free",
    "is_confluent",
    "is_controllable",
    "is_delay_insensitive",
    "is_forcibly_controllable",
    "is_interleave_insensitive",
    "is_isomorphic",
    "is_nonblocking",
    "is_nonblocking_under_control",
    "is_nonconflicting",
    "is_relatively_closed",
    "is_sublanguage",
    "kleene_star",
    "left_quotient",
    "library",
    "lint",
    "load",
    "loads",
    "localize",
    "longest_burst",
    "meet",
    "mermaid",
    "minimize",
    "needs",
    "optimal_supervisor",
    "prefix_closure",
    "project",
    "quotient",
    "random_trace",
    "reachable",
    "read_log",
    "relabel",
    "replay",
    "reverse",
    "run_campaign",
    "run_episode",
    "sample",
    "save",
    "selfloop",
    "shortest_trace",
    "shuffle",
    "simulate",
    "sup_relatively_closed",
    "supcon",
    "supcon_forcing",
    "supervised",
    "supreduce",
    "svg",
    "sync",
    "synthesize",
    "synthesize_modular",
    "table",
    "timed",
    "trim",
    "union",
    "verify",
]


def __getattr__(name: str) -> object:
    if name == "__version__":
        return _import_module("importlib.metadata").version("thenar")
    if name in _LATER:
        where = _LATER[name]
        module = _import_module(f"{where}.{name}" if where == "thenar" else where)
        value = module if where == "thenar" else getattr(module, name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'thenar' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


_set_html_formatter(lambda shown: str(_import_module("thenar.render").html(shown)))
