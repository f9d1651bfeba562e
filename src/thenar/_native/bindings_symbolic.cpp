// Decision diagrams as Python sees them. Long operations run on a thread with a stack deep enough for any number of
// levels, while the calling thread looks out for Ctrl-C and reports progress.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/operators.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "deep_stack.hpp"
#include "order.hpp"
#include "saturation.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace thenar;

namespace {

using Shared = std::shared_ptr<Forest>;

// A set that Python holds.
class Set {
 public:
  Set(Shared forest, Node node) : forest(std::move(forest)), node(node) { this->forest->hold(node); }
  Set(const Set& other) : Set(other.forest, other.node) {}
  Set& operator=(const Set&) = delete;
  ~Set() {
    if (forest->busy) forest->dropped_meanwhile.push_back(node);  // a thread of its own may be looking at what is held
    else forest->drop(node);
  }
  Shared forest;
  Node node;
};

// -- At the door: what is given must belong to the forest, and be as long as it should.

void require(bool holds, const char* otherwise) {
  if (!holds) throw nb::value_error(otherwise);
}

Node own(const Shared& f, const Set& s) {
  require(s.forest == f, "a set of other diagrams: sets are combined within one synthesis");
  return s.node;
}

Relation own(const Shared& f, Relation r) {
  require(f->has_relation(r), "no such relation of these diagrams");
  return r;
}

const std::vector<Relation>& own(const Shared& f, const std::vector<Relation>& relations) {
  for (Relation r : relations) own(f, r);
  return relations;
}

u32 own_level(const Shared& f, u32 level) {
  require(level >= 1 && level <= f->n_levels(), "no such level of these diagrams");
  return level;
}

void falling(const Shared& f, const std::vector<u32>& levels) {
  for (u64 k = 0; k < levels.size(); ++k) {
    own_level(f, levels[k]);
    require(k == 0 || levels[k] < levels[k - 1], "levels must fall");
  }
}

// The union or intersection of many sets, the lowest first, so that each is walked through about once.
template <class F>
Node fold(Forest& f, std::vector<Node> nodes, Node start, Ticker& ticker, F combine) {
  std::stable_sort(nodes.begin(), nodes.end(), [&](Node a, Node b) { return f.level(a) < f.level(b); });
  return operate(f, ticker, [&] {
    Node all = start;
    for (Node n : nodes) all = combine(all, n);
    return all;
  });
}

std::vector<Node> nodes_of(const Shared& f, const std::vector<const Set*>& sets) {
  std::vector<Node> nodes;
  for (const Set* s : sets) {
    nodes.push_back(own(f, *s));
  }
  return nodes;
}

// A state as Python writes it: the value of each level, the top one first.
Forest::State state_of(const Shared& f, const In<u32>& values) {
  require(values.shape(0) == f->n_levels(), "a state has a value for each level");
  Forest::State state(1, 0);
  state.insert(state.end(), std::reverse_iterator(values.data() + values.shape(0)), std::reverse_iterator(values.data()));
  for (u32 level = 1; level <= f->n_levels(); ++level) require(state[level] < f->size(level), "the level has no such value");
  return state;
}

nb::object whole_number(const std::vector<u64>& words) {
  nb::bytes raw(reinterpret_cast<const char*>(words.data()), words.size() * sizeof(u64));
  return nb::module_::import_("builtins").attr("int").attr("from_bytes")(raw, "little");
}

template <class T>
const T* begin_of(const In<T>& a) { return a.data(); }

struct PySaturation {
  Shared forest;
  std::unique_ptr<Saturation> self;
};

Hypergraph hypergraph(u32 n, In<i64> offsets, In<u32> members) {
  const u64 rows = offsets.shape(0), size = members.shape(0);
  require(rows && offsets.data()[0] == 0 && offsets.data()[rows - 1] == static_cast<i64>(size) &&
              std::is_sorted(offsets.data(), offsets.data() + rows), "offsets of edges must rise from 0 to their members");
  require(std::all_of(members.data(), members.data() + size, [n](u32 v) { return v < n; }), "an edge with a vertex beyond n");
  Hypergraph g{n, {offsets.data(), offsets.data() + offsets.shape(0)}, {members.data(), members.data() + members.shape(0)}};
  return g;
}

}  // namespace

void bind_symbolic(nb::module_& m) {
  nb::class_<Set>(m, "Set")
      .def("__and__", [](const Set& a, const Set& b) {
        const Node other = own(a.forest, b);
        return Set(a.forest, operate(*a.forest, [&] { return a.forest->intersect(a.node, other); }));
      }, nb::is_operator())
      .def("__or__", [](const Set& a, const Set& b) {
        const Node other = own(a.forest, b);
        return Set(a.forest, operate(*a.forest, [&] { return a.forest->unite(a.node, other); }));
      }, nb::is_operator())
      .def("__sub__", [](const Set& a, const Set& b) {
        const Node other = own(a.forest, b);
        return Set(a.forest, operate(*a.forest, [&] { return a.forest->subtract(a.node, other); }));
      }, nb::is_operator())
      .def("__invert__", [](const Set& a) {
        return Set(a.forest, operate(*a.forest, [&] { return a.forest->subtract(kEverything, a.node); }));
      })
      .def("__bool__", [](const Set& a) { return a.node != kNothing; })
      .def("__eq__", [](const Set& a, const Set& b) { return a.forest == b.forest && a.node == b.node; }, nb::is_operator())
      .def("__hash__", [](const Set& a) { return a.node; })
      .def_prop_ro("is_everything", [](const Set& a) { return a.node == kEverything; })
      .def_prop_ro("n_nodes", [](const Set& a) { return operate(*a.forest, [&] { return a.forest->n_nodes(a.node); }); })
      .def_prop_ro("level", [](const Set& a) { ready(*a.forest); return a.forest->level(a.node); })
      .def("count", [](const Set& a) { return whole_number(operate(*a.forest, [&] { return a.forest->count(a.node); })); })
      .def("support", [](const Set& a) { return operate(*a.forest, [&] { return a.forest->support(a.node); }); })
      .def("child", [](const Set& a, u32 value) {
        ready(*a.forest);
        const u32 level = a.forest->level(a.node);
        require(!level || value < a.forest->size(level), "the level has no such value");
        return level ? Set(a.forest, a.forest->child(a.node, level, value)) : a;
      }, "value"_a)
      .def("simplify", [](const Set& a, const Set& care) {
        const Node within = own(a.forest, care);
        return Set(a.forest, operate(*a.forest, [&] { return a.forest->simplify(a.node, within); }));
      },
           "care"_a)
      .def("forget", [](const Set& a, In<u8> levels) {
        require(levels.shape(0) == a.forest->n_levels() + 1, "one entry for each level is needed, and one for level 0");
        const std::vector<u8> freed(levels.data(), levels.data() + levels.shape(0));
        return Set(a.forest, operate(*a.forest, [&] { return a.forest->forget(a.node, freed); }));
      }, "levels"_a)
      .def("factors", [](const Set& a) {
        std::vector<Set> found;
        for (Node n : operate(*a.forest, [&] { return a.forest->factors(a.node); })) found.emplace_back(a.forest, n);
        return found;
      })
      .def("products", [](const Set& low, const Set& high, u64 limit) -> std::optional<std::vector<std::vector<std::pair<u32, std::vector<u32>>>>> {
        std::vector<Forest::Product> found;
        const Node bound = own(low.forest, high);
        auto search = [&] { return found.clear(), low.forest->products(low.node, bound, limit, found); };
        if (!operate(*low.forest, search)) return {};
        std::vector<std::vector<std::pair<u32, std::vector<u32>>>> out;
        for (const auto& product : found) {
          auto& row = out.emplace_back();
          for (const auto& literal : product) row.emplace_back(literal.level, literal.values);
        }
        return out;
      }, "high"_a, "limit"_a)
      .def("vectors", [](const Set& a, u64 limit) { return give(operate(*a.forest, [&] { return a.forest->vectors(a.node, limit); })); }, "limit"_a)
      .def("dump", [](const Set& a) {
        std::vector<u32> levels, kids = operate(*a.forest, [&] { return levels.clear(), a.forest->dump(a.node, levels); });
        return nb::make_tuple(give(std::move(levels)), give(std::move(kids)));
      });

  nb::class_<PySaturation>(m, "Saturation")
      .def("__call__", [](PySaturation& s, const Set& start, const Set& within, Ticker& ticker, std::optional<u64> steps) -> std::optional<Set> {
        const Node first = own(s.forest, start), bound = own(s.forest, within);
        prepare(*s.forest, ticker);
        const StepBudget budget(*s.forest, steps.value_or(~u64{0}));
        try {
          return Set(s.forest, run(*s.forest, ticker, [&] { return (*s.self)(first, bound); }));
        } catch (const OutOfSteps&) {
          return {};
        }
      }, "start"_a, "within"_a, "ticker"_a, "steps"_a = nb::none());

  nb::class_<Forest>(m, "Forest")
      .def(nb::new_([](In<u32> sizes, u64 max_bytes, u64 cache_bytes, u64 collect_at) {
        std::vector<u32> values(sizes.data(), sizes.data() + sizes.shape(0));
        return std::make_shared<Forest>(std::move(values), max_bytes, cache_bytes, collect_at);
      }), "sizes"_a, "max_bytes"_a, "cache_bytes"_a, "collect_at"_a)
      .def_prop_ro("nothing", [](const Shared& f) { return Set(f, kNothing); })
      .def_prop_ro("everything", [](const Shared& f) { return Set(f, kEverything); })
      .def_prop_ro("n_nodes", [](const Shared& f) { return f->n_alive(); })
      .def_prop_ro("peak", [](const Shared& f) { return f->n_peak(); })
      .def_prop_ro("collections", [](const Shared& f) { return f->n_collections(); })
      .def_prop_ro("work", [](const Shared& f) { return f->work; })
      .def_prop_ro("bytes", [](const Shared& f) { return f->bytes(); })
      .def_prop_rw("max_bytes", [](const Shared& f) { return f->max_bytes; }, [](const Shared& f, u64 bytes) { f->max_bytes = bytes; })
      .def("watched_by", [](const Shared& f, std::shared_ptr<Ticker> ticker) { f->watch = std::move(ticker); }, "ticker"_a)
      .def("collect", [](const Shared& f) { ready(*f); f->collect(); })
      .def("literal", [](const Shared& f, u32 level, In<u8> mask) {
        require(mask.shape(0) == f->size(own_level(f, level)), "a mask has an entry for each value of its level");
        return Set(f, operate(*f, [&] { return f->literal(level, mask.data()); }));
      },
           "level"_a, "mask"_a)
      .def("table", [](const Shared& f, const std::vector<u32>& levels, In<u8> truth) {
        falling(f, levels);
        u64 cells = 1;
        for (u32 level : levels) cells = std::min<u64>(cells, kNone) * f->size(level);
        require(truth.shape(0) == cells, "a table has an entry for each combination of values");
        return Set(f, operate(*f, [&] { return f->table(levels, truth.data()); }));
      }, "levels"_a, "truth"_a)
      .def("any_of", [](const Shared& f, const std::vector<const Set*>& sets, Ticker& ticker) {
        return Set(f, fold(*f, nodes_of(f, sets), kNothing, ticker, [&](Node a, Node b) { return f->unite(a, b); }));
      }, "sets"_a, "ticker"_a)
      .def("all_of", [](const Shared& f, const std::vector<const Set*>& sets, Ticker& ticker, const Set* within) {
        const Node start = within ? own(f, *within) : kEverything;
        return Set(f, fold(*f, nodes_of(f, sets), start, ticker, [&](Node a, Node b) { return f->intersect(a, b); }));
      }, "sets"_a, "ticker"_a, "within"_a.none() = nb::none())
      // Relations are numbers; 0 is never, 1 the identity.
      .def("shift", [](const Shared& f, u32 level, In<u32> from, In<u32> to, Relation next) {
        ready(*f);
        require(f->relation_level(own(f, next)) < own_level(f, level), "what is done below a level moves lower ones only");
        require(from.shape(0) == to.shape(0), "as many sources as targets are needed");
        std::vector<Pair> pairs(from.shape(0));
        for (u64 k = 0; k < pairs.size(); ++k) {
          pairs[k] = {from.data()[k], to.data()[k], next};
          require(pairs[k].from < f->size(level) && pairs[k].to < f->size(level), "the level has no such value");
        }
        return f->step(level, std::move(pairs));
      }, "level"_a, "source"_a, "target"_a, "next"_a)
      .def("rows", [](const Shared& f, const std::vector<u32>& levels, In<u32> before_after) {
        falling(f, levels);
        const u64 width = 2 * levels.size(), size = before_after.shape(0), n = width ? size / width : 0;
        require(n * width == size, "a row has two values of each level");
        for (u64 k = 0; k < size; ++k)
          require(before_after.data()[k] < f->size(levels[k % width / 2]), "the level has no such value");
        return operate(*f, [&] { return f->rows(levels, before_after.data(), n); });
      }, "levels"_a, "before_after"_a)
      .def("join", [](const Shared& f, Relation a, Relation b) { return operate(*f, [&] { return f->join(own(f, a), own(f, b)); }); }, "a"_a, "b"_a)
      .def("either", [](const Shared& f, Relation a, Relation b) { return operate(*f, [&] { return f->either(own(f, a), own(f, b)); }); }, "a"_a, "b"_a)
      .def("restrict", [](const Shared& f, Relation r, const Set& before) { return operate(*f, [&] { return f->restrict(own(f, r), own(f, before)); }); }, "relation"_a, "before"_a)
      .def("inverse", [](const Shared& f, Relation r) { return operate(*f, [&] { return f->inverse(own(f, r)); }); }, "relation"_a)
      .def("relation_support", [](const Shared& f, Relation r) { return operate(*f, [&] { return f->relation_support(own(f, r)); }); }, "relation"_a)
      .def("domain", [](const Shared& f, Relation r) { return Set(f, operate(*f, [&] { return f->domain(own(f, r)); })); }, "relation"_a)
      .def("image", [](const Shared& f, const Set& set, Relation r) { return Set(f, operate(*f, [&] { return f->image(own(f, set), own(f, r)); })); },
           "set"_a, "relation"_a)
      .def("count_steps", [](const Shared& f, const Set& set, const std::vector<Relation>& relations, Ticker& ticker) {
        const Node inside = own(f, set);
        own(f, relations);
        // steps with long numbers, of which none is kept
        return whole_number(operate(*f, ticker, [&] { return f->count_steps(inside, relations); }, kShort / 32));
      }, "set"_a, "relations"_a, "ticker"_a)
      .def("contains", [](const Shared& f, In<u32> state, const std::vector<const Set*>& sets) {
        const Forest::State values = state_of(f, state);
        std::vector<u8> found;
        for (Node n : nodes_of(f, sets)) found.push_back(f->contains(n, values));
        return give(std::move(found));
      }, "state"_a, "sets"_a)
      .def("lead_into", [](const Shared& f, const Set& set, In<u32> state, const std::vector<Relation>& relations) {
        ready(*f);
        return give(f->lead_into(own(f, set), state_of(f, state), own(f, relations)));
      }, "set"_a, "state"_a, "relations"_a)
      .def("steps", [](const Shared& f, const Set& set, const Set& from, Relation r) {
        std::vector<u32> sources, targets;
        const Node whole = own(f, set), part = own(f, from);
        own(f, r);
        operate(*f, [&] {
          sources.clear(), targets.clear();
          return f->steps(whole, part, r, sources, targets), true;
        });
        return nb::make_tuple(give(std::move(sources)), give(std::move(targets)));
      }, "set"_a, "part"_a, "relation"_a)
      .def("saturation", [](const Shared& f, const std::vector<Relation>& relations) {
        ready(*f);
        return PySaturation{f, std::make_unique<Saturation>(*f, own(f, relations))};
      }, "relations"_a);

  m.def("order", [](u32 n, In<i64> offsets, In<u32> members, const std::string& method, In<u32> start, Ticker& ticker) {
    const Hypergraph g = hypergraph(n, offsets, members);
    Order order(start.data(), start.data() + start.shape(0));
    std::vector<u8> seen(n, 0);
    for (u32 v : order) require(v < n && !seen[v]++, "an order has each vertex once");
    require(order.size() == n, "an order has each vertex once");
    {
      Released free;
      if (method == "force") order = force(g, std::move(order), ticker);
      else if (method == "cuthill_mckee") order = cuthill_mckee(g);
      else if (method == "dissection") order = dissection(g, ticker);
      else if (method == "sloan") order = sloan(g);
      else if (method == "sliding_window") order = sliding_window(g, std::move(order), ticker);
      else require(method.empty(), "no such heuristic");  // the spans of the order given are all that is asked for
    }
    const double total = total_span(g, order), weighted = weighted_span(g, order);
    return nb::make_tuple(give(std::move(order)), total, weighted);
  }, "n"_a, "offsets"_a, "members"_a, "method"_a, "start"_a, "ticker"_a);
}
