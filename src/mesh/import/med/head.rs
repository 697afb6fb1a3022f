//! What a file says of its mesh before nodes and elements.

use super::archive::{Folder, Told};

/// The name of the one mesh, how many coordinates its nodes have, and its last step of geometry.
pub fn step_of(top: &Folder, remarks: &mut Vec<String>) -> Told<(String, usize, Folder)> {
    check_version(top)?;
    let (name, mesh) = only_mesh(top)?;
    if let Some(joints) = top.find_folder("JNT")?
        && joints.has(&name)
    {
        return Err(format!(
            "{}: the mesh is one part of several (joints); write the whole mesh into one file",
            joints.inner(&name)
        ));
    }
    let space = space_of(&mesh, remarks)?;
    let step = last_step(&mesh, remarks)?;
    if step.has("EQS") {
        remarks.push("the equivalences of the file (EQS) join nothing".into());
    }
    Ok((name, space, step))
}

/// Refuses what is no MED file, and versions with another layout.
fn check_version(top: &Folder) -> Told<()> {
    let Some(about) = top.find_folder("INFOS_GENERALES")? else {
        return Err("it is an HDF5 file, but no MED file: /INFOS_GENERALES is missing".into());
    };
    let major = about.attribute("MAJ")?;
    if (3..=4).contains(&major) {
        return Ok(());
    }
    let minor = about.find_attribute("MIN")?.unwrap_or(0);
    Err(format!(
        "{}: it has the version {major}.{minor}; versions 3 and 4 can be read (medimport converts \
         older ones)",
        about.path()
    ))
}

/// The one mesh of the file.
fn only_mesh(top: &Folder) -> Told<(String, Folder)> {
    let all = top.folder("ENS_MAA")?;
    let mut names = all.members()?;
    match names.len() {
        0 => Err(format!("{}: there is no mesh in it", all.path())),
        1 => {
            let name = names.remove(0);
            let mesh = all.folder(&name)?;
            Ok((name, mesh))
        }
        count => Err(format!(
            "{}: it holds {count} meshes ({}); write the one that is wanted into a file of its own",
            all.path(),
            names.join(", ")
        )),
    }
}

/// How many coordinates a node has; refuses meshes without a list of elements.
fn space_of(mesh: &Folder, remarks: &mut Vec<String>) -> Told<usize> {
    let path = mesh.path();
    if mesh.find_attribute("TYP")?.unwrap_or(0) != 0 {
        return Err(format!(
            "{path}: it is a structured mesh (TYP), which is not read; convert it to an \
             unstructured one"
        ));
    }
    if mesh.find_attribute("REP")?.unwrap_or(0) != 0 {
        return Err(format!("{path}: its coordinates are not Cartesian (REP)"));
    }
    if let Some(units) = mesh.text("UNI")?
        && let Some(unit) = units.split_whitespace().find(|unit| *unit != "m")
    {
        remarks.push(format!("the file gives its coordinates in {unit}; they are taken as m"));
    }
    match mesh.attribute("ESP")? {
        2 => Ok(2),
        3 => Ok(3),
        space => Err(format!("{path}: its space has {space} dimensions (ESP); 2 or 3 can be read")),
    }
}

/// The last step of geometry by number and iteration.
fn last_step(mesh: &Folder, remarks: &mut Vec<String>) -> Told<Folder> {
    let mut last: Option<([i64; 2], Folder)> = None;
    let names = mesh.members()?;
    for name in &names {
        let step = mesh.folder(name)?;
        let place = [step.attribute("NDT")?, step.attribute("NOR")?];
        if last.as_ref().is_none_or(|(before, _)| *before < place) {
            last = Some((place, step));
        }
    }
    let missing = || format!("{}: there are no nodes and elements in it", mesh.path());
    let ([number, iteration], step) = last.ok_or_else(missing)?;
    if names.len() > 1 {
        remarks.push(format!(
            "of the {} steps of the mesh the last one is read (number {number}, iteration \
             {iteration})",
            names.len()
        ));
    }
    Ok(step)
}
