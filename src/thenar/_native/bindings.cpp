// The kernel as Python sees it: int arrays in, int arrays out, the GIL released in between.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <optional>

#include "bindings.hpp"
#include "explore.hpp"
#include "graph.hpp"
#include "machine.hpp"
#include "reduction.hpp"
#include "words.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace thenar;

namespace {

// Show memory that `self` owns.
template <class T>
nb::ndarray<nb::numpy, const T, nb::ndim<1>> show(const T* data, u64 n, nb::handle self) {
  return {data, {n}, self};
}

Out<u8> unpack(const Bits& bits) {
  std::vector<u8> out(bits.size());
  for (u64 q = 0; q < out.size(); ++q) out[q] = bits[q];
  return give(std::move(out));
}

Graph graph(const In<i64>& offsets, const In<i32>& events, const In<i32>& targets) {
  return {static_cast<i64>(offsets.shape(0)) - 1, offsets.data(), events.data(), targets.data()};
}

struct PyComponent {  // keeps the arrays of a component alive while it is in use
  In<i64> offsets;
  In<i32> events, targets;
  In<u8> marked, own;
  i32 initial;
  bool plant;
};

struct PyExploration {
  std::vector<PyComponent> inputs;
  std::unique_ptr<Exploration> self;
};

std::unique_ptr<PyExploration> explore(std::vector<PyComponent> inputs, In<u8> uncontrollable, Ticker& ticker) {
  std::vector<Component> components;
  for (const auto& a : inputs)
    components.push_back(
        {graph(a.offsets, a.events, a.targets), a.marked.data(), a.own.data(), a.initial, a.plant});
  const u8* first = uncontrollable.data();
  const std::vector<u8> free_events(first, first + uncontrollable.shape(0));
  Released free;
  auto found = Exploration::explore(components, free_events, ticker);
  return std::make_unique<PyExploration>(PyExploration{std::move(inputs), std::move(found)});
}

}  // namespace

NB_MODULE(kernel, m) {
  bind_symbolic(m);
  nb::set_leak_warnings(false);  // a result that a script still holds when it ends is no leak
  m.doc() = "Kernels over int arrays; see kernel.pyi.";

  nb::register_exception_translator([](const std::exception_ptr& p, void*) {
    try {
      std::rethrow_exception(p);
    } catch (const LimitHit& hit) {
      nb::object type = nb::module_::import_("thenar.errors").attr("LimitReached");
      nb::object error = type(hit.limit, hit.bound, hit.states, hit.transitions);
      PyErr_SetObject(type.ptr(), error.ptr());
    } catch (const TooWide& error) {
      PyErr_SetString(nb::module_::import_("thenar.errors").attr("InputError").ptr(), error.what());
    }
  });

  nb::class_<Ticker>(m, "Ticker")
      .def(
          "__init__",
          [](Ticker* self, std::optional<u64> states, std::optional<u64> transitions, std::optional<u64> bytes,
             std::optional<double> seconds, nb::object progress, double spent) {
            Limits limits;
            if (states) limits.states = *states;
            if (transitions) limits.transitions = *transitions;
            if (bytes) limits.bytes = *bytes;
            if (seconds) limits.seconds = *seconds;
            // The ticker owns a reference to the callback; it is made and dropped with the GIL held.
            new (self) Ticker(limits, [progress = std::move(progress)](u64 n_states, u64 n_transitions) {
              with_gil([&] {
                if (PyErr_CheckSignals()) throw nb::python_error();
                if (!progress.is_none()) progress(n_states, n_transitions);
              });
            }, spent);
          },
          "states"_a = nb::none(), "transitions"_a = nb::none(), "bytes"_a = nb::none(), "seconds"_a = nb::none(),
          "progress"_a = nb::none(), "spent"_a = 0.0)
      .def(
          "look",
          [](Ticker& ticker, u64 states, u64 transitions) {
            ticker.check(states, transitions, 0);
            ticker.tick(1 << 15, states, transitions);
          },
          "states"_a, "transitions"_a);

  nb::class_<PyComponent>(m, "Component")
      .def(
          "__init__",
          [](PyComponent* self, In<i64> offsets, In<i32> events, In<i32> targets, In<u8> marked, In<u8> own, i32 initial,
             bool plant) {
            new (self) PyComponent{std::move(offsets), std::move(events), std::move(targets), std::move(marked),
                                 std::move(own),     initial,           plant};
          },
          "offsets"_a, "events"_a, "targets"_a, "marked"_a, "own"_a, "initial"_a, "plant"_a);

  nb::class_<PyExploration>(m, "Exploration")
      .def_prop_ro("n_states", [](const PyExploration& x) { return x.self->n_states(); })
      .def_prop_ro("n_transitions", [](const PyExploration& x) { return x.self->n_transitions(); })
      .def_prop_ro("bytes", [](const PyExploration& x) { return x.self->bytes(); })
      .def_prop_ro("layout",
                   [](const PyExploration& x) {
                     const Layout& l = x.self->layout();
                     return std::make_tuple(l.words, l.shifts, l.bits);
                   })
      .def(
          "keys",
          [](const PyExploration& x, In<i64> states) {
            const u64 n = states.shape(0), n_words = x.self->layout().n_words;
            for (u64 k = 0; k < n; ++k)
              if (static_cast<u64>(states.data()[k]) >= x.self->n_states()) throw nb::index_error("no such state");
            auto* out = new std::vector<u64>(n * n_words);
            nb::capsule owner(out, [](void* p) noexcept { delete static_cast<std::vector<u64>*>(p); });
            {
              Released free;
              x.self->pack(states.data(), n, out->data());
            }
            return nb::ndarray<nb::numpy, u64, nb::ndim<2>>(out->data(), {n, n_words}, owner);
          },
          "states"_a)
      .def_prop_ro("rank",
                   [](nb::handle_t<PyExploration> h) {
                     auto& x = *nb::cast<PyExploration&>(h).self;
                     return show(x.rank.data(), x.rank.size(), h);
                   }, nb::rv_policy::automatic)
      .def_prop_ro("reason",
                   [](nb::handle_t<PyExploration> h) {
                     auto& x = *nb::cast<PyExploration&>(h).self;
                     return show(x.reason.data(), x.reason.size(), h);
                   }, nb::rv_policy::automatic)
      .def_prop_ro("illegal", [](const PyExploration& x) { return unpack(x.self->illegal()); },
                   nb::rv_policy::automatic)
      .def(
          "fixpoint",
          [](PyExploration& x, Ticker& ticker) {
            Released free;
            x.self->fixpoint(ticker);
          },
          "ticker"_a)
      .def(
          "extract",
          [](const PyExploration& x, Ticker& ticker) {
            Extract e;
            {
              Released free;
              e = x.self->extract(ticker);
            }
            return nb::make_tuple(give(std::move(e.offsets)), give(std::move(e.events)), give(std::move(e.targets)),
                                  give(std::move(e.marked)), give(std::move(e.origin)),
                                  give(std::move(e.disabled_offsets)), give(std::move(e.disabled)));
          },
          "ticker"_a)
      .def(
          "conflict",
          [](const PyExploration& x, Ticker& ticker) {
            std::vector<u8> needed;
            {
              Released free;
              needed = x.self->conflict(ticker);
            }
            return give(std::move(needed));
          },
          "ticker"_a)
      .def(
          "row",
          [](const PyExploration& x, u32 state) {
            Scratch scratch;
            x.self->row(state, scratch);
            std::vector<std::pair<i32, u32>> out;
            for (const auto& [event, target] : scratch.row) out.emplace_back(event, target);
            return out;
          },
          "state"_a)
      .def(
          "path",
          [](const PyExploration& x, u32 start, In<u8> goal, In<u8> inside, bool uncontrollable_only,
             Ticker& ticker) -> std::optional<std::pair<std::vector<i32>, std::vector<i64>>> {
            std::vector<i32> events;
            std::vector<i64> states;
            Released free;
            if (!x.self->path(start, goal.data(), inside.data(), uncontrollable_only, ticker, events, states)) return {};
            return std::make_pair(std::move(events), std::move(states));
          },
          "start"_a, "goal"_a, "inside"_a, "uncontrollable_only"_a, "ticker"_a);

  m.def("explore", &explore, "components"_a, "uncontrollable"_a, "ticker"_a);
  m.def(
      "distance_to",
      [](In<i64> offsets, In<i32> events, In<i32> targets, In<u8> goal, Ticker& ticker) {
        std::vector<i32> distance;
        {
          Released free;
          distance = distance_to(graph(offsets, events, targets), goal.data(), ticker);
        }
        return give(std::move(distance));
      },
      "offsets"_a, "events"_a, "targets"_a, "goal"_a, "ticker"_a);
  m.def(
      "shortest_path",
      [](In<i64> offsets, In<i32> events, In<i32> targets, i64 initial, In<u8> goal,
         Ticker& ticker) -> std::optional<std::vector<i64>> {
        std::vector<i64> transitions;
        Released free;
        if (!shortest_path(graph(offsets, events, targets), initial, goal.data(), ticker, transitions)) return {};
        return transitions;
      },
      "offsets"_a, "events"_a, "targets"_a, "initial"_a, "goal"_a, "ticker"_a);
  m.def(
      "minimize",
      [](In<i64> offsets, In<i32> events, In<i32> targets, i64 n_events, In<u8> marked, Ticker& ticker) {
        std::vector<i32> block;
        {
          Released free;
          block = minimize(graph(offsets, events, targets), n_events, marked.data(), ticker);
        }
        return give(std::move(block));
      },
      "offsets"_a, "events"_a, "targets"_a, "n_events"_a, "marked"_a, "ticker"_a);
  m.def(
      "words",
      [](In<u8> text) {
        Words words;
        {
          Released free;
          words = words_of(text.data(), static_cast<i64>(text.shape(0)));
        }
        return nb::make_tuple(give(std::move(words.ids)), give(std::move(words.starts)), give(std::move(words.ends)));
      },
      "text"_a);
  m.def(
      "project",
      [](In<i64> offsets, In<i32> events, In<i32> targets, i64 n_events, i64 initial, In<u8> marked, In<u8> hidden,
         Ticker& ticker) {
        Projection p;
        {
          Released free;
          p = project(graph(offsets, events, targets), n_events, initial, marked.data(), hidden.data(), ticker);
        }
        return nb::make_tuple(give(std::move(p.offsets)), give(std::move(p.events)), give(std::move(p.targets)),
                              give(std::move(p.marked)), give(std::move(p.member_offsets)), give(std::move(p.members)));
      },
      "offsets"_a, "events"_a, "targets"_a, "n_events"_a, "initial"_a, "marked"_a, "hidden"_a, "ticker"_a);
  m.def(
      "reduce",
      [](In<i64> offsets, In<i32> events, In<i32> targets, i64 n_events, In<i64> disabled_offsets, In<i32> disabled,
         In<u8> mark, Ticker& ticker) {
        Cells cells;
        {
          Released free;
          cells = reduce({graph(offsets, events, targets), static_cast<u64>(n_events), disabled_offsets.data(),
                          disabled.data(), mark.data()},
                         ticker);
        }
        return nb::make_tuple(give(std::move(cells.cell)), cells.lower_bound);
      },
      "offsets"_a, "events"_a, "targets"_a, "n_events"_a, "disabled_offsets"_a, "disabled"_a, "mark"_a, "ticker"_a);
  m.def("random_reads", &random_reads, "n_words"_a, "n_reads"_a, "ticker"_a, nb::call_guard<Released>());
  m.def(
      "stream",
      [](u64 n_words, Ticker& ticker) {
        const Stream s = stream(n_words, ticker);
        return std::make_pair(s.touch, s.read);
      },
      "n_words"_a, "ticker"_a, nb::call_guard<Released>());
}
