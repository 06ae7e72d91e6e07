#include <momentree/models/import/height_grid.hpp>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>

#include <momentree/base/error.hpp>
#include <momentree/text/files/input_file.hpp>

#ifndef __wasm__
#include <dlfcn.h>

#include <csetjmp>
#endif

namespace momentree::io {

namespace {

HeightGrid grid_of(std::int64_t columns, std::int64_t rows) {
  if (columns < 2 || rows < 2) throw_error({"has no two rows and two columns of heights", "", ""});
  if (columns > most_heights || rows > most_heights / columns)
    throw_error({"has more than " + std::to_string(most_heights) + " heights", "", "make it coarser"});
  HeightGrid grid{static_cast<int>(columns), static_cast<int>(rows)};
  grid.values.resize(static_cast<std::size_t>(columns * rows));
  return grid;
}

#ifndef __wasm__

// Functions of libpng throw by longjmp: what has a destructor is outside of decode().
struct Decoder {
  std::jmp_buf failed;
  char why[160];
  void* png;
  void* info;
};

[[noreturn]] void give_up(Decoder& decoder, const char* why) {
  std::snprintf(decoder.why, sizeof decoder.why, "%s", why);
  std::longjmp(decoder.failed, 1);
}

// libpng 1.6, loaded once there is an image: nothing else needs it. Its structures are opaque.
struct PngLibrary {
  using Failed = void (*)(void* png, const char* why);

  void* const library = ::dlopen("libpng16.so.16", RTLD_NOW);
  template <class F>
  F function(const char* name) const {
    return library == nullptr ? nullptr : reinterpret_cast<F>(::dlsym(library, name));
  }
#define MT_PNG(name, result, ...) result (*const name)(__VA_ARGS__) = function<result (*)(__VA_ARGS__)>("png_" #name)
  MT_PNG(create_read_struct, void*, const char* version, void* error, Failed failed, Failed warned);
  MT_PNG(create_info_struct, void*, const void* png);
  MT_PNG(destroy_read_struct, void, void** png, void** info, void** end);
  MT_PNG(get_error_ptr, void*, const void* png);
  MT_PNG(init_io, void, void* png, std::FILE* file);
  MT_PNG(read_png, void, void* png, void* info, int transforms, void* unused);
  MT_PNG(get_rows, std::uint8_t**, const void* png, const void* info);
  MT_PNG(get_image_width, std::uint32_t, const void* png, const void* info);
  MT_PNG(get_image_height, std::uint32_t, const void* png, const void* info);
  MT_PNG(get_channels, std::uint8_t, const void* png, const void* info);
  MT_PNG(get_bit_depth, std::uint8_t, const void* png, const void* info);
#undef MT_PNG
  static constexpr int strip_alpha = 0x0002, expand = 0x0010;  // transforms
};

const PngLibrary& png_library() {
  static const PngLibrary library;
  if (library.get_bit_depth == nullptr)
    throw_error({"cannot be read: PNG images need libpng", "", "install libpng16-16, or write the heights as numbers"});
  return library;
}

bool decode(std::FILE* file, Decoder& decoder) {
  const PngLibrary& png = png_library();
  decoder.png = png.create_read_struct(
      "1.6.0", &decoder,
      [](void* failed, const char* why) { give_up(*static_cast<Decoder*>(png_library().get_error_ptr(failed)), why); },
      [](void*, const char*) {});
  decoder.info = decoder.png == nullptr ? nullptr : png.create_info_struct(decoder.png);
  if (decoder.info == nullptr) return false;
  if (setjmp(decoder.failed) != 0) return false;
  png.init_io(decoder.png, file);
  png.read_png(decoder.png, decoder.info, PngLibrary::expand | PngLibrary::strip_alpha, nullptr);
  return true;
}

#endif

}  // namespace

#ifndef __wasm__

HeightGrid read_height_image(const std::string& path) {
  const PngLibrary& png = png_library();
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) throw_error({"cannot be opened", "", ""});
  Decoder decoder{};
  const auto release = [&png](Decoder* of) { png.destroy_read_struct(&of->png, &of->info, nullptr); };
  const std::unique_ptr<Decoder, decltype(release)> owner(&decoder, release);
  if (!decode(file.get(), decoder)) throw_error({std::string("is no PNG image that can be read: ") + decoder.why, "", ""});
  HeightGrid grid = grid_of(png.get_image_width(decoder.png, decoder.info), png.get_image_height(decoder.png, decoder.info));
  const std::size_t channels = png.get_channels(decoder.png, decoder.info),
                    bytes = png.get_bit_depth(decoder.png, decoder.info) / 8u;
  std::uint8_t* const* const lines = png.get_rows(decoder.png, decoder.info);
  const double white = bytes == 2 ? 65535 : 255;
  for (int j = 0; j < grid.rows; ++j)
    for (int i = 0; i < grid.columns; ++i) {
      const std::uint8_t* const pixel = lines[grid.rows - 1 - j] + static_cast<std::size_t>(i) * channels * bytes;
      double sum = 0;  // of the colours
      for (std::size_t c = 0; c < channels; ++c)
        sum += bytes == 2 ? 256 * pixel[2 * c] + pixel[2 * c + 1] : static_cast<int>(pixel[c]);
      grid.values[static_cast<std::size_t>(j) * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(i)] =
          sum / (white * static_cast<double>(channels));
    }
  return grid;
}

#else

HeightGrid read_height_image(const std::string&) {
  throw_error({"cannot be read: there are no PNG images in browsers", "", "write the heights as numbers"});
}

#endif

HeightGrid read_height_file(const std::string& path) {
  std::string bytes;
  Unreadable why;
  if (!read_whole_file(path, "height field", 8 + 4 * static_cast<std::uintmax_t>(most_heights), bytes, why))
    throw_error({why.what, "", why.hint});
  std::int32_t size[2] = {};
  if (bytes.size() < sizeof size) throw_error({"is too short for a height field", "", ""});
  std::memcpy(size, bytes.data(), sizeof size);
  const std::int64_t rows = size[0], columns = size[1];
  if (rows < 0 || columns < 0 || rows > most_heights || columns > most_heights ||
      static_cast<std::int64_t>(bytes.size()) != 8 + 4 * rows * columns)
    throw_error({"is no height field: it has " + std::to_string(bytes.size()) + " bytes, and begins with " +
                     std::to_string(rows) + " rows and " + std::to_string(columns) + " columns",
                 "", "PNG images end in .png"});
  HeightGrid grid = grid_of(columns, rows);
  for (std::size_t k = 0; k < grid.values.size(); ++k) {
    float value = 0;
    std::memcpy(&value, bytes.data() + 8 + 4 * k, 4);
    grid.values[k] = value;
  }
  return grid;
}

}  // namespace momentree::io
