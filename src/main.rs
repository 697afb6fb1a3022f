use column_hpc::{case::Case, mesh::*, partition, runtime::Runtime, solve};
fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let split = args.iter().position(|a| a == "--").unwrap_or(args.len());
    let runtime = Runtime::start(&args[(split+1).min(args.len())..].to_vec()).unwrap();
    let path = std::path::PathBuf::from(&args[0]);
    let text = std::fs::read_to_string(&path).unwrap();
    let case = match Case::read(&text, &path, &args[1..split]) { Ok(c) => c, Err(e) => { eprintln!("{e}"); return } };
    let column = Column::new(&case).unwrap();
    let t0 = std::time::Instant::now();
    let (cells, coarse) = partition::distribute(&runtime.comm, &column, partition::Method::from_environment()).unwrap();
    let mesh = LocalMesh::refine(&column, &cells, case.mesh.refine, coarse);
    let t1 = std::time::Instant::now();
    let mut model = match solve::build(&runtime, &case, mesh) { Ok(m) => m, Err(e) => { eprintln!("{e}"); return } };
    let t2 = std::time::Instant::now();
    if runtime.comm.is_root() { println!("{} {:?}", model.unknowns, model.choice); println!("mesh {:?} build {:?}", t1-t0, t2-t1); }
    for t in &case.time {
        let t3 = std::time::Instant::now();
        match model.stepper.advance(*t) {
            Ok(a) => {
                let p = &model.stepper.problem;
                let mut v = [f64::NEG_INFINITY; 5];
                let d = case.dim;
                for (r, s) in p.all.secondary.iter().zip(&p.interfaces.response) {
                    if r.rows[d-1].is_some() { v[0] = v[0].max(s.bulk_traction[d-1]); v[1] = v[1].max(-s.bulk_traction[d-1]); }
                    v[2] = v[2].max(s.bulk_traction[0].abs()); v[3] = v[3].max(s.jump[d-1]); v[4] = v[4].max(s.history);
                }
                runtime.comm.max(&mut v);
                if runtime.comm.is_root() { println!("t {t} newton {} linear {} tn {:.10} .. {:.10} shear {:e} jump {:e} kappa {:e} E {:?} {:?}", a.newton_iterations, a.linear_iterations, -v[1], v[0], v[2], v[3], v[4], a.energy, t3.elapsed()); }
            }
            Err(e) => { if runtime.comm.is_root() { println!("{e}"); } break }
        }
    }
}
