#include "order.hpp"

#include <array>
#include <numeric>
#include <queue>

namespace thenar {
namespace {

Order positions(const Order& order) {
  Order at(order.size());
  for (u32 k = 0; k < order.size(); ++k) at[order[k]] = k;
  return at;
}

// Edges of each vertex.
struct Incidence {
  std::vector<i64> offsets;
  std::vector<u32> edges;
  explicit Incidence(const Hypergraph& g) : offsets(g.n_vertices + 1, 0), edges(g.members.size()) {
    for (u32 v : g.members) ++offsets[v + 1];
    std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
    std::vector<i64> next(offsets.begin(), offsets.end() - 1);
    for (u64 e = 0; e < g.n_edges(); ++e)
      for (i64 k = g.offsets[e]; k < g.offsets[e + 1]; ++k) edges[next[g.members[k]]++] = static_cast<u32>(e);
  }
};

// Neighbours of each vertex. A large edge would make a clique of them; its members are joined in a row instead.
struct Graph2 {
  static constexpr i64 kClique = 24;
  std::vector<std::vector<u32>> next;
  explicit Graph2(const Hypergraph& g) : next(g.n_vertices) {
    for (u64 e = 0; e < g.n_edges(); ++e) {
      const i64 lo = g.offsets[e], hi = g.offsets[e + 1];
      for (i64 a = lo; a < hi; ++a)
        for (i64 b = a + 1; b < hi && (hi - lo <= kClique || b == a + 1); ++b) {
          next[g.members[a]].push_back(g.members[b]);
          next[g.members[b]].push_back(g.members[a]);
        }
    }
    for (auto& row : next) {
      std::sort(row.begin(), row.end());
      row.erase(std::unique(row.begin(), row.end()), row.end());
    }
  }
  u64 degree(u32 v) const { return next[v].size(); }

  // Distances from start within its component; the vertices found, nearest first.
  std::vector<u32> breadth_first(u32 start, std::vector<u32>& distance) const {
    std::vector<u32> found{start};
    distance[start] = 0;
    for (u64 k = 0; k < found.size(); ++k)
      for (u32 v : next[found[k]])
        if (distance[v] == kNone) {
          distance[v] = distance[found[k]] + 1;
          found.push_back(v);
        }
    return found;
  }

  // George and Liu: a vertex far out, and one furthest from it.
  std::pair<u32, u32> ends(u32 start, std::vector<u32>& distance) const {
    u32 depth = 0, other = start;
    for (int round = 0; round < 8; ++round) {
      const std::vector<u32> found = breadth_first(start, distance);
      const u32 deepest = distance[found.back()];
      u32 best = found.back();
      for (u64 k = found.size(); k-- > 0 && distance[found[k]] == deepest;)
        if (degree(found[k]) <= degree(best)) best = found[k];
      for (u32 v : found) distance[v] = kNone;
      other = best;
      if (deepest <= depth) break;
      depth = deepest;
      std::swap(start, other);
    }
    return {start, other};
  }
};

}  // namespace

double total_span(const Hypergraph& g, const Order& order) {
  const Order at = positions(order);
  double sum = 0;
  for (u64 e = 0; e < g.n_edges(); ++e) {
    u32 lo = kNone, hi = 0;
    for (i64 k = g.offsets[e]; k < g.offsets[e + 1]; ++k) {
      lo = std::min(lo, at[g.members[k]]);
      hi = std::max(hi, at[g.members[k]]);
    }
    if (hi > lo) sum += hi - lo;
  }
  return sum;
}

// Siminiceanu and Ciardo: spans weigh more the nearer to the top they reach, for all below is worked on again.
double weighted_span(const Hypergraph& g, const Order& order) {
  const Order at = positions(order);
  const double n = g.n_vertices, m = static_cast<double>(std::max<u64>(g.n_edges(), 1));
  double sum = 0;
  for (u64 e = 0; e < g.n_edges(); ++e) {
    u32 lo = kNone, hi = 0;
    for (i64 k = g.offsets[e]; k < g.offsets[e + 1]; ++k) {
      lo = std::min(lo, at[g.members[k]]);
      hi = std::max(hi, at[g.members[k]]);
    }
    if (lo != kNone) sum += 2 * (n - lo) / n * (hi - lo + 1) / n / m;
  }
  return sum;
}

// Aloul, Markov, Sakallah: every vertex to the mean of its edges' centres of gravity, until the spans stop falling.
Order force(const Hypergraph& g, Order order, Ticker& ticker) {
  const Incidence own(g);
  Order best = order;
  double least = total_span(g, order);
  std::vector<double> centre(g.n_edges()), place(g.n_vertices);
  const int rounds = 20 + 10 * std::bit_width(static_cast<u64>(g.n_vertices));
  for (int round = 0, idle = 0; round < rounds && idle < 4; ++round) {
    ticker.tick(g.members.size(), 0, 0);
    const Order at = positions(order);
    for (u64 e = 0; e < g.n_edges(); ++e) {
      double sum = 0;
      for (i64 k = g.offsets[e]; k < g.offsets[e + 1]; ++k) sum += at[g.members[k]];
      centre[e] = sum / static_cast<double>(std::max<i64>(1, g.offsets[e + 1] - g.offsets[e]));
    }
    for (u32 v = 0; v < g.n_vertices; ++v) {
      const i64 lo = own.offsets[v], hi = own.offsets[v + 1];
      double sum = 0;
      for (i64 k = lo; k < hi; ++k) sum += centre[own.edges[k]];
      place[v] = hi > lo ? sum / static_cast<double>(hi - lo) : at[v];
    }
    std::stable_sort(order.begin(), order.end(), [&](u32 a, u32 b) { return place[a] < place[b]; });
    const double span = total_span(g, order);
    if (span < least) least = span, best = order, idle = 0;
    else ++idle;
  }
  return best;
}

Order cuthill_mckee(const Hypergraph& g) {
  const Graph2 graph(g);
  Order order;
  std::vector<u32> distance(g.n_vertices, kNone);
  std::vector<u8> done(g.n_vertices, 0);
  for (u32 v = 0; v < g.n_vertices; ++v) {
    if (done[v]) continue;
    const u32 start = graph.ends(v, distance).first;
    u64 k = order.size();
    order.push_back(start);
    done[start] = 1;
    for (; k < order.size(); ++k) {
      const u64 from = order.size();
      for (u32 u : graph.next[order[k]])
        if (!done[u]) done[u] = 1, order.push_back(u);
      std::stable_sort(order.begin() + static_cast<i64>(from), order.end(),
                       [&](u32 a, u32 b) { return graph.degree(a) < graph.degree(b); });
    }
  }
  return order;
}

// Sloan 1986: next is the vertex that widens the front least, weighed against how far it is from the end.
Order sloan(const Hypergraph& g) {
  constexpr i64 kFar = 1, kWide = 2;
  const Graph2 graph(g);
  Order order;
  std::vector<u32> distance(g.n_vertices, kNone);
  enum : u8 { kInactive, kPreactive, kActive, kDone };
  std::vector<u8> status(g.n_vertices, kInactive);
  std::vector<i64> priority(g.n_vertices);
  for (u32 v = 0; v < g.n_vertices; ++v) {
    if (status[v] != kInactive) continue;
    const auto [start, stop] = graph.ends(v, distance);
    for (u32 u : graph.breadth_first(stop, distance))
      priority[u] = kFar * distance[u] - kWide * static_cast<i64>(graph.degree(u) + 1);
    using Entry = std::tuple<i64, i64, u32>;  // priority, -number for a reproducible order, vertex
    std::priority_queue<Entry> queue;
    auto offer = [&](u32 u) { queue.emplace(priority[u], -static_cast<i64>(u), u); };
    status[start] = kPreactive;
    offer(start);
    while (!queue.empty()) {
      const auto [p, minus, u] = queue.top();
      queue.pop();
      if (status[u] == kDone || p != priority[u]) continue;
      auto raise = [&](u32 w) {
        priority[w] += kWide;
        if (status[w] == kInactive) status[w] = kPreactive;
        offer(w);
      };
      if (status[u] == kPreactive)
        for (u32 w : graph.next[u])
          if (status[w] != kDone) raise(w);
      order.push_back(u);
      status[u] = kDone;
      for (u32 w : graph.next[u])
        if (status[w] == kPreactive) {
          status[w] = kActive;
          raise(w);
          for (u32 x : graph.next[w])
            if (status[x] != kDone) raise(x);
        }
    }
  }
  return order;
}

// The best permutation of each few neighbours in turn. Of an edge only its ends and its members in the window matter.
Order sliding_window(const Hypergraph& g, Order order, Ticker& ticker) {
  constexpr u32 kWindow = 4;
  if (g.n_vertices < 2) return order;
  const u32 width = std::min(kWindow, g.n_vertices);
  const Incidence own(g);
  const Order at = positions(order);
  std::vector<u32> first(g.n_edges(), kNone), last(g.n_edges(), 0);  // places of the ends of each edge
  for (u64 e = 0; e < g.n_edges(); ++e)
    for (i64 k = g.offsets[e]; k < g.offsets[e + 1]; ++k) {
      first[e] = std::min(first[e], at[g.members[k]]);
      last[e] = std::max(last[e], at[g.members[k]]);
    }
  std::vector<u32> edges;
  std::vector<u8> inside(g.n_edges(), 0);  // which vertices of the window are members
  std::array<u32, kWindow> index;          // the vertex at each place of the window
  for (u32 lo = 0; lo + width <= g.n_vertices; ++lo) {
    edges.clear();
    for (u32 k = 0; k < width; ++k)
      for (i64 j = own.offsets[order[lo + k]]; j < own.offsets[order[lo + k] + 1]; ++j) {
        const u32 e = own.edges[j];
        if (!inside[e]) edges.push_back(e);
        inside[e] |= static_cast<u8>(1u << k);
      }
    // Where the edge begins and ends with the window in the order of `index`; further ends stay.
    auto begin = [&](u32 e) {
      if (first[e] < lo) return first[e];
      u32 k = 0;
      while (!(inside[e] >> index[k] & 1)) ++k;
      return lo + k;
    };
    auto end = [&](u32 e) {
      if (last[e] >= lo + width) return last[e];
      u32 k = width - 1;
      while (!(inside[e] >> index[k] & 1)) --k;
      return lo + k;
    };
    std::iota(index.begin(), index.end(), 0);
    std::array<u32, kWindow> best = index;
    i64 least = -1;
    do {
      ticker.tick(edges.size(), 0, 0);
      i64 span = 0;
      for (u32 e : edges) span += end(e) - begin(e);
      if (least < 0 || span < least) least = span, best = index;
    } while (std::next_permutation(index.begin(), index.begin() + width));
    index = best;
    for (u32 e : edges) {
      const u32 from = begin(e), to = end(e);
      first[e] = from, last[e] = to;
      inside[e] = 0;
    }
    const Order window(order.begin() + lo, order.begin() + lo + width);
    for (u32 k = 0; k < width; ++k) order[lo + k] = window[best[k]];
  }
  return order;
}

namespace {

// Few vertices that hold the rest together go first; what then falls apart is ordered part by part.
class Dissection {
 public:
  Dissection(const Hypergraph& g, Ticker& ticker) : g_(g), ticker_(ticker), local_(g.n_vertices, kNone) {}
  Order order;

  void operator()(const std::vector<u32>& vertices) {
    const u64 n = vertices.size();
    // A large edge is long in any order and says little: without the largest ones more falls apart.
    for (u64 most = n; ; most = std::max<u64>(kShort, most / 2)) {
      std::vector<u32> rest = vertices, hubs;
      Hypergraph part = restricted(rest, most);
      std::vector<std::vector<u32>> pieces = components(part, rest);
      const u64 few = n > kSmall ? std::clamp<u64>(n / 8, 2, 24) : 0;
      while (2 * largest(pieces) > n && hubs.size() < few && most < n) {
        ticker_.tick(part.members.size() * 4, 0, 0);
        const Graph2 graph(part);
        u32 hub = 0;
        for (u32 v = 1; v < part.n_vertices; ++v)
          if (graph.degree(v) > graph.degree(hub)) hub = v;
        hubs.push_back(rest[hub]);
        rest.erase(rest.begin() + hub);
        part = restricted(rest, most);
        pieces = components(part, rest);
      }
      const bool falls_apart = most == n ? pieces.size() > 1 : n > kSmall && 2 * largest(pieces) <= n;
      if (falls_apart) {
        order.insert(order.end(), hubs.begin(), hubs.end());
        for (const auto& piece : pieces) (*this)(piece);
        return;
      }
      if (n <= kSmall || most == kShort) break;
    }
    leaf(vertices);
  }

 private:
  static constexpr u64 kSmall = 12, kShort = 6;
  static u64 largest(const std::vector<std::vector<u32>>& pieces) {
    u64 size = 0;
    for (const auto& piece : pieces) size = std::max<u64>(size, piece.size());
    return size;
  }
  // The edges of at most so many members within `vertices`, numbered as they are there.
  Hypergraph restricted(const std::vector<u32>& vertices, u64 most) {
    for (u32 k = 0; k < vertices.size(); ++k) local_[vertices[k]] = k;
    Hypergraph part{static_cast<u32>(vertices.size()), {0}, {}};
    for (u64 e = 0; e < g_.n_edges(); ++e) {
      const u64 first = part.members.size();
      for (i64 k = g_.offsets[e]; k < g_.offsets[e + 1]; ++k)
        if (const u32 v = local_[g_.members[k]]; v != kNone) part.members.push_back(v);
      const u64 size = part.members.size() - first;
      if (size < 2 || size > most) part.members.resize(first);
      else part.offsets.push_back(static_cast<i64>(part.members.size()));
    }
    for (u32 v : vertices) local_[v] = kNone;
    return part;
  }
  static std::vector<std::vector<u32>> components(const Hypergraph& part, const std::vector<u32>& vertices) {
    std::vector<u32> root(part.n_vertices);
    std::iota(root.begin(), root.end(), 0);
    auto find = [&](u32 v) {
      while (root[v] != v) v = root[v] = root[root[v]];
      return v;
    };
    for (u64 e = 0; e < part.n_edges(); ++e)
      for (i64 k = part.offsets[e] + 1; k < part.offsets[e + 1]; ++k) {
        const u32 a = find(part.members[k - 1]), b = find(part.members[k]);
        root[std::max(a, b)] = std::min(a, b);
      }
    std::vector<std::vector<u32>> pieces;
    std::vector<u32> piece(part.n_vertices, kNone);
    for (u32 v = 0; v < part.n_vertices; ++v) {
      const u32 r = find(v);
      if (piece[r] == kNone) piece[r] = static_cast<u32>(pieces.size()), pieces.emplace_back();
      pieces[piece[r]].push_back(vertices[v]);
    }
    return pieces;
  }
  void leaf(const std::vector<u32>& vertices) {
    const Hypergraph part = restricted(vertices, vertices.size());
    Order start(part.n_vertices);
    std::iota(start.begin(), start.end(), 0);
    Order best;
    for (Order& found : std::array{force(part, start, ticker_), sloan(part), cuthill_mckee(part)}) {
      found = sliding_window(part, std::move(found), ticker_);
      if (best.empty() || total_span(part, found) < total_span(part, best)) best = std::move(found);
    }
    for (u32 v : best) order.push_back(vertices[v]);
  }

  const Hypergraph& g_;
  Ticker& ticker_;
  std::vector<u32> local_;
};

}  // namespace

Order dissection(const Hypergraph& g, Ticker& ticker) {
  Order all(g.n_vertices);
  std::iota(all.begin(), all.end(), 0);
  Dissection dissect(g, ticker);
  dissect(all);
  return std::move(dissect.order);
}

}  // namespace thenar
