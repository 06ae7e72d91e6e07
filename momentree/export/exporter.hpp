#pragma once
// The interface of exporters. A format is a source in exporters/ which defines a function of the file's name, in the namespace
// `exporters`:
//   Exporter usd() { return {.ending = ".usda", .format = "USD", .content = "USD", .readers = "3D programs", .bytes = &usd_of}; }
// The command line, its help and its messages, and the Python package get their formats from the list of these files.
#include <string>

#include <momentree/export/drawing.hpp>
#include <momentree/export/exporter_list.hpp>  // generated from the files in exporters/

namespace momentree::io {

struct Exporter {
  const char* ending;   ///< of the names of its files, in small letters: ".usda"
  const char* format;   ///< its name, for messages
  const char* content;  ///< what it is in a few words, for help: "animated glTF"
  const char* readers;  ///< the programs that read it, for messages
  /// The content of a file. Throws Error; `drawing` has at least one row.
  std::string (*bytes)(const Drawing& drawing);
};

namespace exporters {
#define MOMENTREE_EXPORTER(name, Type) Exporter name();
MOMENTREE_EXPORTERS(MOMENTREE_EXPORTER)
#undef MOMENTREE_EXPORTER
}  // namespace exporters

}  // namespace momentree::io
