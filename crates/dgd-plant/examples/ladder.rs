//! Prints the thesis's ladder for the given seeds: `cargo run --release -p dgd-plant --example ladder -- 5`.
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "prints a table for the README"
)]
#![allow(dead_code, reason = "the tests use more of the solver")]

use dgd_plant::{Plan, record};

#[path = "../tests/it/solver.rs"]
mod solver;

fn main() {
    for seed in std::env::args().skip(1).map(|a| a.parse::<u64>().unwrap()) {
        let s = solver::screen(&record(&Plan::gom(seed)).unwrap());
        let kept = s.keep.iter().filter(|&&k| k).count();
        let delay = s.best_delay();
        let (early, mse_early) = s.quadratic(0);
        let (late, mse_late) = s.quadratic(delay);
        let (cubic, mse_cubic) = s.cubic(delay);
        let (head, mse_head) = s.head(delay, 2.0, 2.0);
        let (n0, n2, free) = s.exponents(delay);
        let scale = 14.79 / mse_late;
        println!(
            "seed {seed}: kept {kept}, delay {delay} s, friction {:.2} : 14.79 : {:.2}, \
             C {:.0} and {:.0}, D {:.1}, E {:.4}, c2 {:.5}, pump ratio {:.1} at n0 {n0:.3}, n2 {n2:.3}",
            mse_early * scale,
            mse_cubic * scale,
            early[0],
            late[0],
            cubic[1],
            cubic[2],
            head[2],
            mse_head / free,
        );
    }
}
