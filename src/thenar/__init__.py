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
    from thenar.explicit.nondeterminism import determinise
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
    from thenar.explicit.strings import count_strings, enabled_after, sample
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
    from thenar.synthesis.lint import lint
    from thenar.synthesis.modular import ModularResult, synthesize_modular
    from thenar.synthesis.simulate import Status, Step, random_trace, simulate
    from thenar.synthesis.verify import Verdict, verify

# Imported when first used: import thenar pulls NumPy and the kernel only.
_LATER = {
    **dict.fromkeys(
        ("Condition", "ExtendedAutomaton", "ExtendedProblem", "Variable", "disables", "invariant", "needs"),
        "thenar.model.extended",
    ),
    **dict.fromkeys(("Guards", "guards", "supervised"), "thenar.symbolic.guards"),
    "SymbolicSupervisor": "thenar.symbolic.synthesis",
    **dict.fromkeys(("ModularResult", "synthesize_modular"), "thenar.synthesis.modular"),
    **dict.fromkeys(("Campaign", "run_campaign"), "thenar.hand.campaign"),
    **dict.fromkeys(("Episode", "run_episode"), "thenar.hand.episode"),
    "Block": "thenar.hand.objects",
    **dict.fromkeys(("Detector", "Driver", "Signal", "Skill"), "thenar.runtime.driver"),
    "execute": "thenar.runtime.executor",
    **dict.fromkeys(("Log", "LogWriter", "read_log"), "thenar.runtime.record"),
    **dict.fromkeys(("Replay", "replay"), "thenar.runtime.replay"),
    "Run": "thenar.runtime.run",
    **dict.fromkeys(("dumps", "load", "loads", "save"), "thenar.io"),
    **dict.fromkeys(("html", "mermaid", "svg", "table"), "thenar.render"),
    "certificate": "thenar.synthesis.certificate",
    "fit_to_run": "thenar.synthesis.deploy",
    "lint": "thenar.synthesis.lint",
    **dict.fromkeys(
        ("Explanation", "Violation", "explain", "explain_disabled", "explain_empty", "explain_removed"),
        "thenar.synthesis.explain",
    ),
    **dict.fromkeys(("Status", "Step", "random_trace", "simulate"), "thenar.synthesis.simulate"),
    **dict.fromkeys(("Verdict", "verify"), "thenar.synthesis.verify"),
    "determinise": "thenar.explicit.nondeterminism",
    **dict.fromkeys(
        (
            "concatenation",
            "difference",
            "inverse_project",
            "kleene_star",
            "left_quotient",
            "prefix_closure",
            "quotient",
            "reverse",
            "union",
        ),
        "thenar.explicit.regular",
    ),
    **dict.fromkeys(("count_strings", "enabled_after", "sample"), "thenar.explicit.strings"),
    "Saved": "thenar.io",
    "library": "thenar",
}

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
    "Detector",
    "Driver",
    "Episode",
    "Event",
    "Explanation",
    "ExtendedAutomaton",
    "ExtendedProblem",
    "Fault",
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
    "closed_loop",
    "complement",
    "concatenation",
    "condat",
    "coreachable",
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
    "fit_to_run",
    "guards",
    "html",
    "invariant",
    "inverse_project",
    "is_controllable",
    "is_isomorphic",
    "is_nonblocking",
    "is_nonconflicting",
    "is_sublanguage",
    "kleene_star",
    "left_quotient",
    "library",
    "lint",
    "load",
    "loads",
    "meet",
    "mermaid",
    "minimize",
    "needs",
    "prefix_closure",
    "project",
    "quotient",
    "random_trace",
    "reachable",
    "read_log",
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
    "supcon",
    "supervised",
    "svg",
    "sync",
    "synthesize",
    "synthesize_modular",
    "table",
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
