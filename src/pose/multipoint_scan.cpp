// Both rays over tiles of samples, several at a time. Every lane does the same operations in the same order, contraction is off:
// a value's bits do not depend on the instruction set. Compiled so that loops with square roots and choices become vectors
// (src/pose/dependencies.cmake): no errno, which is never read, and no traps, which are never on.
#include "pose/multipoint_scan.hpp"

// As in the part room: a portable binary that is fast where it runs; sanitizers run before the resolvers can.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_THREAD__) && \
    !defined(__SANITIZE_ADDRESS__)
#define TRUNNION_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define TRUNNION_CLONES
#endif
#define TRUNNION_INLINE inline __attribute__((always_inline))

namespace trunnion::detail {

namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();

TRUNNION_INLINE double root(double x) {
    return __builtin_sqrt(x > 0.0 ? x : 0.0);
}

struct Axes {
    double o[3], x[3], y[3], z[3];
};

struct Numbers {
    double Ro, Ri, top, Pv, Pw, to_P[3], near2;
    bool open, up;
};

TRUNNION_CLONES void heights_of(const double* __restrict tx, const double* __restrict ty, const double* __restrict tz,
                                const Axes& axes, double Ro, double Ri, double least_t, double* __restrict out) {
    const Axes f = axes;
    for (int k = 0; k < Tile::kPadded; ++k) {
        const double dx = tx[k] - f.o[0], dy = ty[k] - f.o[1], dz = tz[k] - f.o[2];
        const double X = f.x[0] * dx + f.x[1] * dy + f.x[2] * dz, Y = f.y[0] * dx + f.y[1] * dy + f.y[2] * dz;
        const double off = root(X * X + Y * Y) - Ro, t = off > least_t ? off : least_t, q = Ri * Ri - t * t;
        const double F = f.z[0] * dx + f.z[1] * dy + f.z[2] * dz + root(q);
        out[k] = q >= 0.0 ? F : kNever;
    }
}

/// What a sample's circle meets: `across` and `value` are R^2 times the sine and the cosine of the turn.
TRUNNION_CLONES void cosines_of(const double* __restrict tx, const double* __restrict ty, const double* __restrict tz,
                                const Axes& axes, const Numbers& numbers, double* __restrict out) {
    const Axes f = axes;
    const Numbers n = numbers;
    const double sign = n.up ? 1.0 : -1.0, quarter = 0.25 / n.Ro, disc_bound = n.up && !n.open ? n.Ro * n.Ro : -1.0;
    for (int k = 0; k < Tile::kPadded; ++k) {
        const double dx = tx[k] - f.o[0], dy = ty[k] - f.o[1], dz = tz[k] - f.o[2];
        const double u = f.x[0] * dx + f.x[1] * dy + f.x[2] * dz, v = f.y[0] * dx + f.y[1] * dy + f.y[2] * dz + n.Pv,
                     w = f.z[0] * dx + f.z[1] * dy + f.z[2] * dz + n.Pw;
        const double dd = dx * dx + dy * dy + dz * dz, b = dd + 2.0 * (n.to_P[0] * dx + n.to_P[1] * dy + n.to_P[2] * dz);
        const double u2 = u * u, R2 = b - u2 + n.Ri * n.Ri, over = 1.0 / R2;
        const double vs = n.Ro + quarter * b - n.Ro * u2 / b, h2 = R2 - vs * vs, h = -sign * root(h2);
        const double value = (v * vs + w * h) * over, across = sign * (v * h - w * vs);
        double best = (b > 0.0) & (h2 > 0.0) & (across >= 0.0) ? value : kNever;
        const double q = R2 - n.Ri * n.Ri, vd = root(q), off = vd - n.Ro;
        const double disc_value = (v * vd - n.Ri * w) * over, disc_across = -n.Ri * v - w * vd;
        best = (q > 0.0) & (u2 + off * off <= disc_bound) & (disc_across >= 0.0) & (disc_value > best) ? disc_value : best;
        out[k] = dd >= n.near2 ? best : kNever;
    }
}

/// The walls, where the tile reaches them at all.
TRUNNION_CLONES void walls_of(const double* __restrict tx, const double* __restrict ty, const double* __restrict tz,
                              const Axes& axes, const Numbers& numbers, double* __restrict out) {
    const Axes f = axes;
    const Numbers n = numbers;
    const double sign = n.up ? 1.0 : -1.0, D2 = n.Ro + n.Ri;
    for (int k = 0; k < Tile::kPadded; ++k) {
        const double dx = tx[k] - f.o[0], dy = ty[k] - f.o[1], dz = tz[k] - f.o[2];
        const double u = f.x[0] * dx + f.x[1] * dy + f.x[2] * dz, v = f.y[0] * dx + f.y[1] * dy + f.y[2] * dz + n.Pv,
                     w = f.z[0] * dx + f.z[1] * dy + f.z[2] * dz + n.Pw;
        const double dd = dx * dx + dy * dy + dz * dz, R2 = v * v + w * w;
        const double q = D2 * D2 - u * u, vf = n.Ro + sign * root(q), h2 = R2 - vf * vf, h = root(h2);
        const double value = (v * vf + w * h) / R2, across = sign * (v * h - w * vf);
        out[k] = (q > 0.0) & (h2 > 0.0) & (h2 <= n.top * n.top) & (across >= 0.0) & (dd >= n.near2) & (value > out[k]) ? value
                                                                                                                       : out[k];
    }
}

void put(double* out, const Vec3& v) {
    out[0] = v.x(), out[1] = v.y(), out[2] = v.z();
}

}  // namespace

// Floor: about 30 flops and 2 square roots a sample.
void scan_heights(const ToolShape& tool, const Tile& tile, const Vec3& o, const Vec3& ex, const Vec3& ey, const Vec3& ez,
                  Block& heights) {
    Axes f;
    put(f.o, o), put(f.x, ex), put(f.y, ey), put(f.z, ez);
    heights_of(tile.x.data(), tile.y.data(), tile.z.data(), f, tool.Ro, tool.Ri, tool.open ? kNever : 0.0, heights.data());
}

// Floor: about 60 flops, 1 to 3 square roots and 2 divisions a sample.
void scan_turns(const ToolShape& tool, const Tile& tile, const Insert& frame, bool up, bool walls, double near, Block& cosines) {
    Axes f;
    put(f.o, frame.P), put(f.x, frame.eu), put(f.y, frame.ev), put(f.z, frame.ew);
    Numbers n{tool.Ro, tool.Ri, tool.top, frame.Pv, frame.Pw, {}, near * near, tool.open, up};
    put(n.to_P, frame.P - frame.O1);
    cosines_of(tile.x.data(), tile.y.data(), tile.z.data(), f, n, cosines.data());
    if (walls) walls_of(tile.x.data(), tile.y.data(), tile.z.data(), f, n, cosines.data());
}

}  // namespace trunnion::detail
