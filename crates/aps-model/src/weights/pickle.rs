//! Just enough of Python's pickle format to describe tensors, and no more: nothing is executed.
//!
//! Values are nodes of one list and refer to each other by number. Every instruction makes at most one node and every
//! reference is one instruction's, so that memory stays in proportion to the bytes read, however often a value is reused,
//! and nothing recurses. (A pickle that repeats a pair of a pair of a pair is small in bytes and endless when copied.)

use std::collections::HashMap;

/// Number of a node.
pub(super) type Id = usize;

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Node {
    /// A whole number, of at most 64 bits.
    Int(i64),
    /// Text.
    Text(String),
    /// A tuple.
    Tuple(Vec<Id>),
    /// A dictionary, of any class, in the order of writing.
    Dict(Vec<(Id, Id)>),
    /// A list.
    List(Vec<Id>),
    /// A class or function: module, blank, name.
    Global(String),
    /// A call that is only written down: a [`Node::Global`] and a [`Node::Tuple`], if the file is sound.
    Call(Id, Id),
    /// Something outside the pickle, by its id.
    Persistent(Id),
    /// None, a truth value, a fraction, bytes: what no tensor's description needs.
    Other,
}

/// A parsed pickle.
#[derive(Debug)]
pub(super) struct Pickle {
    nodes: Vec<Node>,
    /// The value it is of.
    pub root: Id,
}

/// Longest name of a class or function with its module \[bytes\]. Instructions of a few bytes may name one by a text that they share.
const LONGEST_GLOBAL: usize = 256;

fn global(module: &str, name: &str) -> Result<String, String> {
    match module.len() + name.len() {
        0..LONGEST_GLOBAL => Ok(format!("{module} {name}")),
        length => Err(format!("a class with a name of {length} bytes")),
    }
}

impl Pickle {
    /// Reads up to the stop instruction; what follows is ignored, as Python does.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, String> {
        let mut machine = Machine {
            bytes,
            at: 0,
            nodes: Vec::new(),
            stack: Vec::new(),
            marks: Vec::new(),
            memo: HashMap::new(),
        };
        let root = machine.run();
        let root = root.map_err(|e| format!("{e}, at byte {}", machine.at))?;
        Ok(Self {
            nodes: machine.nodes,
            root,
        })
    }

    /// The node of that number.
    pub(super) fn get(&self, id: Id) -> &Node {
        &self.nodes[id]
    }
}

struct Machine<'a> {
    bytes: &'a [u8],
    at: usize,
    nodes: Vec<Node>,
    stack: Vec<Id>,
    /// Heights of the stack at the open marks.
    marks: Vec<usize>,
    memo: HashMap<u32, Id>,
}

type Step<T = ()> = Result<T, String>;

impl<'a> Machine<'a> {
    fn run(&mut self) -> Step<Id> {
        loop {
            let [code] = self.array()?;
            if code == b'.' {
                return self.pop();
            }
            self.step(code)?;
        }
    }

    /// One instruction, named in the comments as in Python's `pickletools`.
    fn step(&mut self, code: u8) -> Step {
        match code {
            // PROTO, FRAME
            0x80 => self.take(1).map(|_| ()),
            0x95 => self.take(8).map(|_| ()),
            // GLOBAL, STACK_GLOBAL
            b'c' => {
                let (module, name) = (self.line()?, self.line()?);
                self.push(Node::Global(global(&module, &name)?))
            }
            0x93 => {
                let (name, module) = (self.pop()?, self.pop()?);
                let node = match (&self.nodes[module], &self.nodes[name]) {
                    (Node::Text(module), Node::Text(name)) => Node::Global(global(module, name)?),
                    _ => return Err("a class without a name".to_owned()),
                };
                self.push(node)
            }
            // BINPUT, LONG_BINPUT, MEMOIZE
            b'q' | b'r' => {
                let key = self.number(code == b'r')?;
                self.remember(key)
            }
            0x94 => self.remember(self.memo.len() as u32),
            // BINGET, LONG_BINGET
            b'h' | b'j' => {
                let key = self.number(code == b'j')?;
                self.recall(key)
            }
            // BININT, BININT1, BININT2, LONG1
            b'J' => {
                let value = i32::from_le_bytes(self.array()?);
                self.push(Node::Int(value.into()))
            }
            b'K' => {
                let [value] = self.array()?;
                self.push(Node::Int(value.into()))
            }
            b'M' => {
                let value = u16::from_le_bytes(self.array()?);
                self.push(Node::Int(value.into()))
            }
            0x8a => {
                let [length] = self.array()?;
                let node = long(self.take(length.into())?);
                self.push(node)
            }
            // BINUNICODE, SHORT_BINUNICODE
            b'X' | 0x8c => {
                let length = self.number(code == b'X')?;
                let text = self.take(length as usize)?.to_vec();
                let text = String::from_utf8(text).map_err(|_| "text that is not UTF-8")?;
                self.push(Node::Text(text))
            }
            // NONE, NEWTRUE, NEWFALSE, BINFLOAT, SHORT_BINBYTES, BINBYTES
            b'N' | 0x88 | 0x89 => self.push(Node::Other),
            b'G' => self.take(8).and_then(|_| self.push(Node::Other)),
            b'C' | b'B' => {
                let length = self.number(code == b'B')?;
                self.take(length as usize)?;
                self.push(Node::Other)
            }
            // MARK, TUPLE, EMPTY_TUPLE, TUPLE1, TUPLE2, TUPLE3
            b'(' => {
                self.marks.push(self.stack.len());
                Ok(())
            }
            b't' => {
                let items = self.since_mark()?;
                self.push(Node::Tuple(items))
            }
            b')' => self.push(Node::Tuple(Vec::new())),
            0x85..=0x87 => {
                let items = self.pop_many(usize::from(code - 0x84))?;
                self.push(Node::Tuple(items))
            }
            // EMPTY_LIST, APPEND, APPENDS
            b']' => self.push(Node::List(Vec::new())),
            b'a' => {
                let items = self.pop_many(1)?;
                self.append(items)
            }
            b'e' => {
                let items = self.since_mark()?;
                self.append(items)
            }
            // EMPTY_DICT, SETITEM, SETITEMS
            b'}' => self.push(Node::Dict(Vec::new())),
            b's' => {
                let items = self.pop_many(2)?;
                self.set(&items)
            }
            b'u' => {
                let items = self.since_mark()?;
                self.set(&items)
            }
            // BINPERSID
            b'Q' => {
                let id = self.pop()?;
                self.push(Node::Persistent(id))
            }
            // REDUCE, NEWOBJ
            b'R' | 0x81 => {
                let (arguments, function) = (self.pop()?, self.pop()?);
                let is_dict = matches!(&self.nodes[function], Node::Global(name)
                    if name == "collections OrderedDict" || name == "collections defaultdict");
                self.push(match is_dict {
                    true => Node::Dict(Vec::new()),
                    false => Node::Call(function, arguments),
                })
            }
            // BUILD: attributes, of which no tensor needs any.
            b'b' => self.pop().map(|_| ()),
            other => Err(format!(
                "instruction {other:#04x} is not one that a file of tensors needs"
            )),
        }
    }

    fn take(&mut self, count: usize) -> Step<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        if rest.len() < count {
            return Err("it ends too early".to_owned());
        }
        self.at += count;
        Ok(&rest[..count])
    }

    fn array<const N: usize>(&mut self) -> Step<[u8; N]> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    /// A number without sign, of four bytes or one.
    fn number(&mut self, is_long: bool) -> Step<u32> {
        match is_long {
            true => self.array().map(u32::from_le_bytes),
            false => self.array().map(|[byte]| byte.into()),
        }
    }

    fn line(&mut self) -> Step<String> {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| b == b'\n');
        let length = length.ok_or("it ends too early")?;
        self.at += length + 1;
        Ok(String::from_utf8_lossy(&rest[..length]).into_owned())
    }

    fn push(&mut self, node: Node) -> Step {
        self.stack.push(self.nodes.len());
        self.nodes.push(node);
        Ok(())
    }

    /// Takes a value off the stack, but none below the last mark.
    fn pop(&mut self) -> Step<Id> {
        let is_there = self.stack.len() > self.marks.last().copied().unwrap_or(0);
        let top = self.stack.pop_if(|_| is_there);
        top.ok_or_else(|| "an instruction lacks its operand".to_owned())
    }

    fn pop_many(&mut self, count: usize) -> Step<Vec<Id>> {
        let mut items = (0..count).map(|_| self.pop()).collect::<Step<Vec<_>>>()?;
        items.reverse();
        Ok(items)
    }

    fn since_mark(&mut self) -> Step<Vec<Id>> {
        let start = self.marks.pop();
        let start = start.ok_or("a collection without its beginning")?;
        Ok(self.stack.split_off(start))
    }

    fn remember(&mut self, key: u32) -> Step {
        let id = *self.stack.last().ok_or("nothing to remember")?;
        self.memo.insert(key, id);
        Ok(())
    }

    fn recall(&mut self, key: u32) -> Step {
        let id = self.memo.get(&key);
        let id = id.ok_or("a value that was never remembered")?;
        self.stack.push(*id);
        Ok(())
    }

    fn append(&mut self, items: Vec<Id>) -> Step {
        let list = self.pop()?;
        self.stack.push(list);
        match &mut self.nodes[list] {
            Node::List(all) => all.extend(items),
            // A list of an unknown class: nothing a tensor needs.
            Node::Call(..) => {}
            _ => return Err("an element for something that is no list".to_owned()),
        }
        Ok(())
    }

    fn set(&mut self, items: &[Id]) -> Step {
        let dict = self.pop()?;
        self.stack.push(dict);
        let pairs = items.chunks_exact(2);
        if !pairs.remainder().is_empty() {
            return Err("a key without a value".to_owned());
        }
        match &mut self.nodes[dict] {
            Node::Dict(all) => all.extend(pairs.map(|pair| (pair[0], pair[1]))),
            Node::Call(..) => {}
            _ => return Err("an entry for something that is no dictionary".to_owned()),
        }
        Ok(())
    }
}

/// A whole number in two's complement, little-endian; beyond 64 bits it is nothing a tensor needs.
fn long(bytes: &[u8]) -> Node {
    if bytes.len() > 8 {
        return Node::Other;
    }
    let negative = bytes.last().is_some_and(|b| b & 0x80 != 0);
    let mut all = [if negative { 0xff } else { 0 }; 8];
    all[..bytes.len()].copy_from_slice(bytes);
    Node::Int(i64::from_le_bytes(all))
}
