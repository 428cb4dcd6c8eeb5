//! Host times of what the control core computes, beside the same in double precision as one would write it without its tables and
//! prepared sums. Ratios on one machine are what counts; what the target pays is in docs/cost.md.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use tautrack::math::sin_cos;
use tautrack::robots::b2p2::Model;
use tautrack::robots::b2p2::shape::{AXLE_3_FROM_BODY_3, BODY_1, BODY_2, BODY_3};
use tautrack::screw::Geometry;
use tautrack::settings::Settings;
use tautrack::stability::support::Stance;
use tautrack::units::Angle;

const SUPPORT: [[f64; 2]; 4] = [[0.0, -0.16], [0.77, -0.16], [0.77, 0.16], [0.0, 0.16]];

/// Every body turned and weighed on its own.
fn centre_of_gravity(theta: f64, l3: f64) -> [f64; 3] {
    let (sin, cos) = theta.sin_cos();
    let front = |body: [f32; 3], slid: f64| {
        let [along, left, up] = body.map(f64::from);
        [
            0.32 + (along + slid) * cos - up * sin,
            left,
            (along + slid) * sin + up * cos,
        ]
    };
    let slid = 0.23 + l3 - f64::from(AXLE_3_FROM_BODY_3);
    let bodies = [
        (BODY_1.mass, BODY_1.place.map(f64::from)),
        (BODY_2.mass, front(BODY_2.place, 0.0)),
        (BODY_3.mass, front(BODY_3.place, slid)),
    ];
    let total: f64 = bodies.iter().map(|(mass, _)| f64::from(*mass)).sum();
    [0, 1, 2].map(|axis| {
        bodies
            .iter()
            .map(|(mass, place)| f64::from(*mass) * place[axis])
            .sum::<f64>()
            / total
    })
}

fn extension(theta: f64) -> (f64, f64) {
    let (l1, l2, k) = black_box((0.32, 0.23, 1.232));
    let (sin, cos) = theta.sin_cos();
    let r = (k * k - l1 * l1) / (2.0 * (k + l1 * cos));
    (r - l2, r * l1 * sin / (k + l1 * cos))
}

fn double_margins(support: &[[f64; 2]; 4], cog: [f64; 2]) -> [f64; 4] {
    [0, 1, 2, 3].map(|corner| {
        let (from, to) = (support[corner], support[(corner + 1) % 4]);
        let edge = [to[0] - from[0], to[1] - from[1]];
        let offset = [cog[0] - from[0], cog[1] - from[1]];
        (edge[0] * offset[1] - edge[1] * offset[0]) / edge[0].hypot(edge[1])
    })
}

fn model(criterion: &mut Criterion) {
    let (angle, radians) = (Angle::from_radians(0.7), 0.7_f64);
    let mut group = criterion.benchmark_group("sine and cosine");
    group.bench_function("table, f32", |bench| {
        bench.iter(|| sin_cos(black_box(angle)));
    });
    group.bench_function("plain, f64", |bench| {
        bench.iter(|| black_box(radians).sin_cos());
    });
    group.finish();

    let geometry =
        Geometry::from_micrometres(320_000, 230_000, 1_232_000).expect("the nominal geometry");
    let mut group = criterion.benchmark_group("screw extension with derivative");
    group.bench_function("table, fixed point", |bench| {
        bench.iter(|| geometry.extension(black_box(angle)));
    });
    group.bench_function("plain, f64", |bench| {
        bench.iter(|| extension(black_box(radians)));
    });
    group.finish();

    let b2p2 = Model::new(&Settings::default());
    let mut group = criterion.benchmark_group("CoG of B2P2");
    group.bench_function("prepared, f32", |bench| {
        bench.iter(|| b2p2.shape(black_box(angle), black_box(0.3)).cog);
    });
    group.bench_function("plain, f64", |bench| {
        bench.iter(|| centre_of_gravity(black_box(radians), black_box(0.3)));
    });
    group.finish();

    let support = SUPPORT.map(|[x, y]| [x as f32, y as f32, 0.0]);
    let mut group = criterion.benchmark_group("four margins");
    group.bench_function("f32", |bench| {
        bench.iter(|| Stance::on(black_box(support), black_box([0.3, 0.05, 0.1])).margins());
    });
    group.bench_function("plain, f64", |bench| {
        bench.iter(|| double_margins(black_box(&SUPPORT), black_box([0.3, 0.05])));
    });
    group.finish();
}

criterion_group!(benches, model);
criterion_main!(benches);
