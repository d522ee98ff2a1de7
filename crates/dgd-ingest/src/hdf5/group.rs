//! The names in a group, in the old layout (symbol tables) and the new one (links).

use crate::mat::Fault;

use super::dense;
use super::file::{Cursor, File};
use super::object::{LINK, LINK_INFO, Object, SYMBOL_TABLE, text};

/// Most names in one group.
pub(super) const MAX_LINKS: usize = 65_536;
const MAX_LINK_NAME: usize = 1024;

/// A name and the address of the object header it stands for.
pub(super) type Link = (String, u64);

/// The hard links of a group in the order of the file, and how many were of another kind;
/// `None` if the object is no group.
pub(super) fn links(
    file: &File<'_>,
    object: &Object<'_>,
) -> Result<Option<(Vec<Link>, usize)>, Fault> {
    let mut links = Vec::new();
    let mut other = 0;
    let mut group = false;
    for message in &object.messages {
        let mut body = message.body.clone();
        match message.kind {
            SYMBOL_TABLE => {
                group = true;
                let tree = body.offset()?;
                let heap = body.offset()?;
                let names = local_heap(file, heap)?;
                let mut nodes = file.data.len() / 8;
                symbol_tree(file, tree, None, names, &mut nodes, &mut links, &mut other)?;
            }
            LINK => {
                group = true;
                push(link(&mut body)?, &mut links, &mut other);
            }
            LINK_INFO => {
                group = true;
                body.skip(1)?;
                let flags = body.u8()?;
                if flags & 1 != 0 {
                    body.skip(8)?;
                }
                let (heap, index) = (body.offset()?, body.offset()?);
                if !file.undefined(heap) {
                    let first = links.len();
                    for mut body in dense::records(file, heap, index)? {
                        push(link(&mut body)?, &mut links, &mut other);
                    }
                    // The index is in the order of a hash; old groups are in that of names.
                    links[first..].sort();
                }
            }
            _ => {}
        }
        if links.len() > MAX_LINKS {
            return Err(Fault::damaged(
                file.place(body.at as u64),
                format!("a group of more than {MAX_LINKS} names"),
            ));
        }
    }
    Ok(group.then_some((links, other)))
}

fn push(link: Option<Link>, links: &mut Vec<Link>, other: &mut usize) {
    match link {
        Some(link) => links.push(link),
        None => *other += 1,
    }
}

/// A link message; `None` for soft and external links.
fn link(body: &mut Cursor<'_>) -> Result<Option<Link>, Fault> {
    let version = body.u8()?;
    if version != 1 {
        return Err(body.damaged(format!("link version {version}, expected 1")));
    }
    let flags = body.u8()?;
    let kind = if flags & 8 != 0 { body.u8()? } else { 0 };
    if flags & 4 != 0 {
        body.skip(8)?;
    }
    if flags & 0x10 != 0 {
        body.skip(1)?;
    }
    let length = body.unsigned(1 << (flags & 3))?;
    let name = match usize::try_from(length) {
        Ok(length) if length <= MAX_LINK_NAME => body.take(length)?,
        _ => return Err(body.damaged(format!("a name of {length} bytes"))),
    };
    Ok(if kind == 0 {
        Some((text(name), body.offset()?))
    } else {
        None
    })
}

/// The bytes of the names of an old group.
fn local_heap<'a>(file: &File<'a>, address: u64) -> Result<&'a [u8], Fault> {
    let mut cursor = file.cursor_from(address)?;
    cursor.expect(b"HEAP")?;
    cursor.skip(4)?;
    let size = cursor.length()?;
    let _free = cursor.length()?;
    let data = cursor.offset()?;
    file.bytes(data, size)
}

/// Walks the B-tree of an old group; `level` strictly falls, so that no loop is endless.
fn symbol_tree(
    file: &File<'_>,
    address: u64,
    below: Option<u8>,
    names: &[u8],
    nodes: &mut usize,
    links: &mut Vec<Link>,
    other: &mut usize,
) -> Result<(), Fault> {
    let mut cursor = file.cursor_from(address)?;
    cursor.expect(b"TREE")?;
    let (kind, level) = (cursor.u8()?, cursor.u8()?);
    let count = cursor.u16()?;
    if kind != 0 || below.is_some_and(|below| level >= below) || *nodes == 0 {
        return Err(cursor.damaged("the tree of the group's names is tangled"));
    }
    *nodes -= 1;
    cursor.skip(2 * file.offset_size)?;
    for _ in 0..count {
        let _key = cursor.length()?;
        let child = cursor.offset()?;
        if level > 0 {
            symbol_tree(file, child, Some(level), names, nodes, links, other)?;
        } else {
            symbol_node(file, child, names, nodes, links, other)?;
        }
    }
    Ok(())
}

fn symbol_node(
    file: &File<'_>,
    address: u64,
    names: &[u8],
    nodes: &mut usize,
    links: &mut Vec<Link>,
    other: &mut usize,
) -> Result<(), Fault> {
    let mut cursor = file.cursor_from(address)?;
    cursor.expect(b"SNOD")?;
    cursor.skip(2)?;
    let count = cursor.u16()?;
    for _ in 0..count {
        if *nodes == 0 || links.len() > MAX_LINKS {
            return Err(cursor.damaged("the tree of the group's names is tangled"));
        }
        *nodes -= 1;
        let name = cursor.offset()?;
        let header = cursor.offset()?;
        let cached = cursor.u32()?;
        cursor.skip(20)?;
        let name = usize::try_from(name)
            .ok()
            .and_then(|at| names.get(at..))
            .ok_or_else(|| cursor.damaged("a name lies outside the group's heap"))?;
        let name = text(&name[..name.len().min(MAX_LINK_NAME)]);
        // 2 marks a soft link.
        push((cached != 2).then_some((name, header)), links, other);
    }
    Ok(())
}
