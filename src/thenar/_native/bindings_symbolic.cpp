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
#include <pthread.h>

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>

#include "bindings.hpp"
#include "order.hpp"
#include "saturation.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace thenar;

namespace {

struct Cancelled {};

// Run `work` and wait for it; throws what it throws, or what the ticker throws meanwhile.
void on_deep_stack(Forest& forest, Ticker& ticker, const std::function<void()>& work) {
  struct Shared {
    const std::function<void()>& work;
    std::mutex mutex;
    std::condition_variable done_changed;
    bool done = false;
    std::exception_ptr error;
    std::atomic<bool> cancel = false;
    std::atomic<u64> nodes = 0, steps = 0;
  } shared{work};
  Ticker inner({}, [&](u64 nodes, u64 steps) {
    shared.nodes = nodes;
    shared.steps = steps;
    if (shared.cancel) throw Cancelled();
  });
  forest.ticker = &inner;
  forest.busy = true;
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  // Two frames a level and more, each below a kilobyte; memory that is not touched costs nothing.
  pthread_attr_setstacksize(&attributes, (u64{16} << 20) + u64{8192} * forest.n_levels());
  pthread_t thread;
  std::exception_ptr stopped;
  auto run = [](void* argument) -> void* {
    auto& s = *static_cast<Shared*>(argument);
    try {
      s.work();
    } catch (...) {
      s.error = std::current_exception();
    }
    std::lock_guard lock(s.mutex);
    s.done = true;
    s.done_changed.notify_one();
    return nullptr;
  };
  {
    nb::gil_scoped_release free;
    const bool started = pthread_create(&thread, &attributes, run, &shared) == 0;
    if (!started) {
      shared.done = true;
      shared.error = std::make_exception_ptr(std::bad_alloc());
    }
    std::unique_lock lock(shared.mutex);
    while (!shared.done_changed.wait_for(lock, std::chrono::milliseconds(50), [&] { return shared.done; })) {
      if (stopped) continue;
      lock.unlock();
      try {
        ticker.tick(1 << 20, shared.nodes, shared.steps);
      } catch (...) {
        stopped = std::current_exception();
        shared.cancel = true;
      }
      lock.lock();
    }
    lock.unlock();
    if (started) pthread_join(thread, nullptr);
    if (!shared.error) shared.error = stopped;
  }
  pthread_attr_destroy(&attributes);
  forest.ticker = nullptr;
  forest.busy = false;
  for (Node n : std::exchange(forest.dropped_meanwhile, {})) forest.drop(n);
  if (shared.error) {
    forest.stack().clear();
    std::rethrow_exception(stopped ? stopped : shared.error);
  }
}

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

Node same(const Set& a, const Set& b) {
  if (a.forest != b.forest) throw nb::value_error("sets over different variables");
  return b.node;
}

// Before each operation: the forest must not be at work for another thread, and has its garbage collected if due.
void ready(Forest& f) {
  if (f.busy) throw std::runtime_error("these diagrams are at work in another thread; give each thread its own synthesis");
  if (f.collection_is_due()) f.collect();
}

// Do one operation: where it stands, or, if so many levels might be too deep for the calling thread, on a deep stack.
template <class F>
auto operate(Forest& f, F operation) {
  constexpr u32 kShallow = 12'000;  // some 4 MB of stack
  ready(f);
  if (f.n_levels() <= kShallow) return operation();
  decltype(operation()) result{};
  Ticker ticker({}, [](u64, u64) {
    nb::gil_scoped_acquire hold;
    if (PyErr_CheckSignals()) throw nb::python_error();
  });
  on_deep_stack(f, ticker, [&] { result = operation(); });
  return result;
}

// The union or intersection of many sets, the lowest first, so that each is walked through about once.
template <class F>
Node fold(Forest& f, std::vector<Node> nodes, Node start, Ticker& ticker, F combine) {
  ready(f);
  std::stable_sort(nodes.begin(), nodes.end(), [&](Node a, Node b) { return f.level(a) < f.level(b); });
  Node all = start;
  auto work = [&] {
    for (Node n : nodes) all = combine(all, n);
  };
  // A few literals are not worth a thread.
  if (start <= kEverything && nodes.size() <= 16 && std::all_of(nodes.begin(), nodes.end(), [&](Node n) { return f.is_literal(n); }))
    work();
  else
    on_deep_stack(f, ticker, work);
  return all;
}

std::vector<Node> nodes_of(const Shared& f, const std::vector<const Set*>& sets) {
  std::vector<Node> nodes;
  for (const Set* s : sets) {
    if (s->forest != f) throw nb::value_error("sets over different variables");
    nodes.push_back(s->node);
  }
  return nodes;
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
  Hypergraph g{n, {offsets.data(), offsets.data() + offsets.shape(0)}, {members.data(), members.data() + members.shape(0)}};
  return g;
}

}  // namespace

void bind_symbolic(nb::module_& m) {
  nb::class_<Set>(m, "Set")
      .def("__and__", [](const Set& a, const Set& b) {
        return Set(a.forest, operate(*a.forest, [&] { return a.forest->intersect(a.node, same(a, b)); }));
      })
      .def("__or__", [](const Set& a, const Set& b) {
        return Set(a.forest, operate(*a.forest, [&] { return a.forest->unite(a.node, same(a, b)); }));
      })
      .def("__sub__", [](const Set& a, const Set& b) {
        return Set(a.forest, operate(*a.forest, [&] { return a.forest->subtract(a.node, same(a, b)); }));
      })
      .def("__invert__", [](const Set& a) {
        return Set(a.forest, operate(*a.forest, [&] { return a.forest->subtract(kEverything, a.node); }));
      })
      .def("__bool__", [](const Set& a) { return a.node != kNothing; })
      .def("__eq__", [](const Set& a, const Set& b) { return a.node == same(a, b); })
      .def("__hash__", [](const Set& a) { return a.node; })
      .def_prop_ro("is_everything", [](const Set& a) { return a.node == kEverything; })
      .def_prop_ro("n_nodes", [](const Set& a) { ready(*a.forest); return a.forest->n_nodes(a.node); })
      .def_prop_ro("level", [](const Set& a) { ready(*a.forest); return a.forest->level(a.node); })
      .def("count", [](const Set& a) { return whole_number(operate(*a.forest, [&] { return a.forest->count(a.node); })); })
      .def("support", [](const Set& a) { return operate(*a.forest, [&] { return a.forest->support(a.node); }); })
      .def("child", [](const Set& a, u32 value) {
        ready(*a.forest);
        const u32 level = a.forest->level(a.node);
        return level ? Set(a.forest, a.forest->child(a.node, level, value)) : a;
      }, "value"_a)
      .def("simplify", [](const Set& a, const Set& care) {
        return Set(a.forest, operate(*a.forest, [&] { return a.forest->simplify(a.node, same(a, care)); }));
      },
           "care"_a)
      .def("forget", [](const Set& a, In<u8> levels) {
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
        const Node bound = same(low, high);
        if (!operate(*low.forest, [&] { return low.forest->products(low.node, bound, limit, found); })) return {};
        std::vector<std::vector<std::pair<u32, std::vector<u32>>>> out;
        for (const auto& product : found) {
          auto& row = out.emplace_back();
          for (const auto& literal : product) row.emplace_back(literal.level, literal.values);
        }
        return out;
      }, "high"_a, "limit"_a)
      .def("vectors", [](const Set& a, u64 limit) { return give(operate(*a.forest, [&] { return a.forest->vectors(a.node, limit); })); }, "limit"_a)
      .def("dump", [](const Set& a) {
        ready(*a.forest);
        std::vector<u32> levels, kids = a.forest->dump(a.node, levels);
        return nb::make_tuple(give(std::move(levels)), give(std::move(kids)));
      });

  nb::class_<PySaturation>(m, "Saturation")
      .def("__call__", [](PySaturation& s, const Set& start, const Set& within, Ticker& ticker) {
        Node found = kNothing;
        ready(*s.forest);
        on_deep_stack(*s.forest, ticker, [&] { found = (*s.self)(start.node, within.node); });
        return Set(s.forest, found);
      }, "start"_a, "within"_a, "ticker"_a);

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
      .def_prop_ro("bytes", [](const Shared& f) { return f->bytes(); })
      .def("collect", [](const Shared& f) { ready(*f); f->collect(); })
      .def("literal", [](const Shared& f, u32 level, In<u8> mask) { return Set(f, operate(*f, [&] { return f->literal(level, mask.data()); })); },
           "level"_a, "mask"_a)
      .def("table", [](const Shared& f, const std::vector<u32>& levels, In<u8> truth) {
        return Set(f, operate(*f, [&] { return f->table(levels, truth.data()); }));
      }, "levels"_a, "truth"_a)
      .def("any_of", [](const Shared& f, const std::vector<const Set*>& sets, Ticker& ticker) {
        return Set(f, fold(*f, nodes_of(f, sets), kNothing, ticker, [&](Node a, Node b) { return f->unite(a, b); }));
      }, "sets"_a, "ticker"_a)
      .def("all_of", [](const Shared& f, const std::vector<const Set*>& sets, Ticker& ticker, const Set* within) {
        const Node start = within ? within->node : kEverything;
        return Set(f, fold(*f, nodes_of(f, sets), start, ticker, [&](Node a, Node b) { return f->intersect(a, b); }));
      }, "sets"_a, "ticker"_a, "within"_a.none() = nb::none())
      // Relations are numbers; 0 is never, 1 the identity.
      .def("shift", [](const Shared& f, u32 level, In<u32> from, In<u32> to, Relation next) {
        ready(*f);
        std::vector<Pair> pairs(from.shape(0));
        for (u64 k = 0; k < pairs.size(); ++k) pairs[k] = {from.data()[k], to.data()[k], next};
        return f->step(level, std::move(pairs));
      }, "level"_a, "source"_a, "target"_a, "next"_a)
      .def("rows", [](const Shared& f, const std::vector<u32>& levels, In<u32> before_after) {
        const u64 n = levels.empty() ? 0 : before_after.shape(0) / (2 * levels.size());
        return operate(*f, [&] { return f->rows(levels, before_after.data(), n); });
      }, "levels"_a, "before_after"_a)
      .def("join", [](const Shared& f, Relation a, Relation b) { return operate(*f, [&] { return f->join(a, b); }); }, "a"_a, "b"_a)
      .def("either", [](const Shared& f, Relation a, Relation b) { return operate(*f, [&] { return f->either(a, b); }); }, "a"_a, "b"_a)
      .def("restrict", [](const Shared& f, Relation r, const Set& before) { return operate(*f, [&] { return f->restrict(r, before.node); }); }, "relation"_a, "before"_a)
      .def("inverse", [](const Shared& f, Relation r) { return operate(*f, [&] { return f->inverse(r); }); }, "relation"_a)
      .def("relation_support", [](const Shared& f, Relation r) { return operate(*f, [&] { return f->relation_support(r); }); }, "relation"_a)
      .def("domain", [](const Shared& f, Relation r) { return Set(f, operate(*f, [&] { return f->domain(r); })); }, "relation"_a)
      .def("image", [](const Shared& f, const Set& set, Relation r) { return Set(f, operate(*f, [&] { return f->image(set.node, r); })); },
           "set"_a, "relation"_a)
      .def("count_steps", [](const Shared& f, const Set& set, const std::vector<Relation>& relations, Ticker& ticker) {
        std::vector<u64> words;
        ready(*f);
        on_deep_stack(*f, ticker, [&] { words = f->count_steps(set.node, relations); });
        return whole_number(words);
      }, "set"_a, "relations"_a, "ticker"_a)
      .def("steps", [](const Shared& f, const Set& set, const Set& from, Relation r) {
        std::vector<u32> sources, targets;
        const Node part = same(set, from);
        operate(*f, [&] { return f->steps(set.node, part, r, sources, targets), true; });
        return nb::make_tuple(give(std::move(sources)), give(std::move(targets)));
      }, "set"_a, "part"_a, "relation"_a)
      .def("saturation", [](const Shared& f, const std::vector<Relation>& relations) {
        ready(*f);
        return PySaturation{f, std::make_unique<Saturation>(*f, relations)};
      }, "relations"_a);

  m.def("order", [](u32 n, In<i64> offsets, In<u32> members, const std::string& method, In<u32> start, Ticker& ticker) {
    const Hypergraph g = hypergraph(n, offsets, members);
    Order order(start.data(), start.data() + start.shape(0));
    {
      nb::gil_scoped_release free;
      if (method == "force") order = force(g, std::move(order), ticker);
      else if (method == "cuthill_mckee") order = cuthill_mckee(g);
      else if (method == "dissection") order = dissection(g, ticker);
      else if (method == "sloan") order = sloan(g);
      else if (method == "sliding_window") order = sliding_window(g, std::move(order), ticker);
    }
    const double total = total_span(g, order), weighted = weighted_span(g, order);
    return nb::make_tuple(give(std::move(order)), total, weighted);
  }, "n"_a, "offsets"_a, "members"_a, "method"_a, "start"_a, "ticker"_a);
}
