use super::rig::{answer, case};
#[test]
fn explore() {
    for e in [None, Some("influx"), Some("line_restriction"), Some("return_flow_delay")] {
        for seed in [301_u64, 302, 303] {
            let c = case(seed, e);
            let t = std::time::Instant::now();
            let d = answer(&c);
            eprintln!("{seed} {e:?} n={} dt={} form={:?} {:?} truth {:?} {:?}", c.plan.samples(), c.sampling_s, c.form, t.elapsed(), c.hidden.first().map(|h| (&h.params, h.interval_s)), d.verdict);
            for f in &d.findings { eprintln!("   {} p={:.2} {:?} {:?} ev {:.0}", f.effect, f.probability, f.intervals_s, f.parameters.iter().map(|p| (p.name.clone(), p.estimate, p.ci95)).collect::<Vec<_>>(), f.evidence); }
        }
    }
}
