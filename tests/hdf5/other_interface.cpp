// A plugin of another version of momentree.
extern "C" const void* momentree_plugin_hdf5() {
  static const int interface = 999;
  return &interface;
}
