//! Recordings of three benches, for `SYSTEMS.md` and the tests: `cargo run -p dgd-cli --example benches -- FOLDER`.
//!
//! Each bench is written out as differential equations of its own and integrated by Runge and Kutta's method of order four; nothing
//! of the crates that it is fitted with is used. The truth stands here, in `physics.rs`.

mod physics;

use std::path::Path;

fn main() -> std::io::Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "benches".into());
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    for (name, system, recording) in physics::all() {
        std::fs::write(folder.join(format!("{name}.toml")), system)?;
        std::fs::write(folder.join(format!("{name}.csv")), recording)?;
    }
    Ok(())
}
