"""The components of a CIF model: instances, scopes, and the files that they are in."""

from __future__ import annotations

from pathlib import Path

import thenar
from thenar.io import cif
from thenar.model.extended import Edge, ExtendedAutomaton, ExtendedProblem
from thenar.model.problem import Problem


def guards(problem: ExtendedProblem, name: str | None = None) -> list[str]:
    """Return the edges of an automaton (of the first plant without a name), written down."""
    a = problem.plants[0] if name is None else problem.automaton(name)
    return [arrow(a, edge) for edge in a.edges]


def arrow(a: ExtendedAutomaton, edge: Edge) -> str:
    guard = "" if str(edge.guard) == "true" else f" when {edge.guard}"
    updates = "".join(f" {v} := {x}" for v, x in edge.updates)
    return f"{a.states[edge.source]} -{a.alphabet[edge.event].name}-> {a.states[edge.target]}{guard}{updates}"


def test_instances_get_absolute_names_and_their_parameters() -> None:
    problem = cif.loads(
        """
        group def Cell(controllable go; alg int most, start; location where; Lamp other):
          plant counter: disc int[0..9] n = start; uncontrollable back;
            location: initial; marked;
              edge go when n < most and where do n := n + 1; edge back when other.On do n := 0; end
          controllable local;
        end
        plant def Lamp(): controllable on;
          location Off: initial; marked; edge on goto On; location On: edge on goto Off; end
        c1: Cell(l.on, 3, 1 + 1, l.Off, l);
        l: Lamp();
        c2: Cell(c1.local, c1.counter.n, 0, l.On, l);
        """
    )
    assert [a.name for a in problem.plants] == ["c1.counter", "l", "c2.counter"]
    assert guards(problem, "c1.counter") == [
        "* -l.on-> * when c1.counter.n < 3 and l.Off c1.counter.n := c1.counter.n + 1",
        "* -c1.counter.back-> * when l.On c1.counter.n := 0",
    ]
    assert guards(problem, "c2.counter")[0] == (
        "* -c1.local-> * when c2.counter.n < c1.counter.n and l.On c2.counter.n := c2.counter.n + 1"
    )
    assert [v.initial for v in problem.variables] == [(2,), (0,)]


def test_a_name_is_looked_for_from_the_inside_out() -> None:
    problem = cif.loads(
        """
        const int n = 1; controllable c;
        group a:
          const int n = 2;
          plant def D(): location: initial; marked; edge c when w.v = n and w.v = .n and w.v = .a.n; end
          group b: const int n = 3; x: D(); y: a.D();
            plant q: disc int[0..9] v; location: initial; edge c when v = n; end end
        end
        plant w: disc int[0..9] v; location: initial; end
        """
    )
    assert guards(problem, "a.b.x") == ["* -c-> * when w.v == 2 and w.v == 1 and w.v == 2"]
    assert guards(problem, "a.b.y") == guards(problem, "a.b.x")
    assert guards(problem, "a.b.q") == ["* -c-> * when a.b.q.v == 3"]


def test_words_of_cif_are_names_behind_a_dollar() -> None:
    problem = cif.loads("controllable $event; plant $plant: location $initial: initial; edge $event goto $initial; end")
    assert problem.plants[0].name == "plant"
    assert guards(problem) == ["initial -event-> initial"]


def test_pictures_prints_and_annotations_are_passed_over() -> None:
    problem = cif.loads(
        """
        @@doc("a (bracketed; text)")
        svgfile "a;b.svg"; svgout id "x" text value fmt("%d; // no", p.n) /* ; */; // ; "
        svgin id "b" event if p.n = 1: c else c end; print "n", p.n pre "x";
        controllable c;
        plant p: disc int[0..1] n;
          @state(x: "(", y: {1: (2, 3)})
          location: initial; edge c;
          svgcopy id "a" post "b"; end
        """
    )
    assert guards(problem) == ["* -c-> *"]


def write(folder: Path, **files: str) -> Path:
    for name, text in files.items():
        path = folder / f"{name.replace('__', '/')}.cif"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


def test_imports_are_relative_and_read_once_and_groups_continue(tmp_path: Path) -> None:
    write(
        tmp_path,
        main='import "lib/a.cif", "lib/b.cif"; group g: plant p: location: initial; edge e, x.f, .top; end end',
        lib__a='import "b.cif"; group g: group x: controllable f; end end',
        lib__b="group g: controllable e; end controllable top;",
    )
    problem = thenar.load(tmp_path / "main.cif")
    assert isinstance(problem, Problem)  # a plain one, as it has neither variables nor conditions
    assert problem.name == "main"
    assert problem.alphabet.names == ("g.e", "top", "g.x.f")
    text = (tmp_path / "main.cif").read_text()
    assert cif.loads(text, "main.cif", search=tmp_path).alphabet == problem.alphabet


def test_a_namespace_puts_a_file_into_a_group(tmp_path: Path) -> None:
    write(
        tmp_path,
        main='import "lib.cif"; plant p: location: initial; edge a.b.e; end group a: group b: const int k = 1; end end',
        lib="namespace a.b; controllable e; plant q: location: initial; edge e; end",
    )
    problem = cif.load(tmp_path / "main.cif")
    assert [a.name for a in problem.plants] == ["a.b.q", "p"]


def test_a_larger_folder_may_be_searched(tmp_path: Path) -> None:
    write(tmp_path, models__main='import "../lib.cif"; plant p: location: initial; edge e; end', lib="controllable e;")
    assert cif.load(tmp_path / "models" / "main.cif", search=tmp_path).alphabet.names == ("e",)


def test_the_text_of_a_cif_model_is_read_when_asked_for() -> None:
    text = "plant p: disc bool b; location: initial; end"
    assert repr(thenar.loads(text, "cif")) == repr(cif.loads(text))
